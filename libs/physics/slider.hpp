#pragma once

#include "physics/joint_axis.hpp"

namespace physics {

// scene::Mechanism of kind slider. J_parent and J_child coincide at position 0; the child moves along z of J_parent.
struct SliderParams {
  core::Pose X_PJ;
  core::Pose X_CJ;
  JointAxisParams axis;  // m, N
};

// Tunables: damping, locked, motor_m_per_s, motor_force_N.
class Slider final : public Mechanism {
 public:
  explicit Slider(const SliderParams& params);
  void Prepare(const BodyView& parent, const BodyView& child, double dt_s) override;
  void Finish(double dt_s) override;
  void ExchangeState(Checkpoint* checkpoint) override;

 private:
  std::span<Row> axis_rows() { return std::span(rows()).subspan(kFirstAxisRow, JointAxis::kNumRows); }

  static constexpr std::size_t kFirstAxisRow = 5;
  SliderParams params_;
  JointAxis axis_;
};

}  // namespace physics
