#pragma once

#include <optional>

#include "physics/row.hpp"

namespace physics {

struct SpringCouplingParams {
  double stiffness_N_per_m = 8000.0;
  double damping_N_s_per_m = 65.0;
  double stiffness_Nm_per_rad = 100.0;
  double damping_Nm_s_per_rad = 1.0;
};

// What friction between two jaws holds: the limit surface of a soft finger [Howe, Cutkosky 1996],
//   (f / force_N)^2 + (tau / torque_Nm)^2 = 1,
// f the force across the jaws' axis, tau the torque about it. Between rigid pads with friction mu, normal forces N_i at
// distances r_i from the pads' middle, force_N is mu sum N_i and torque_Nm is mu sum N_i r_i.
struct GripLimit {
  glm::dvec3 axis_P{1.0, 0.0, 0.0};  // of the jaws, in the parent's axes
  double force_N = 0.0;
  double torque_Nm = 0.0;
};

// 6-DoF spring-damper that holds the child at its relative pose of the attachment: the grasp of architecture section 1,
// with the gripper as parent. The linear spring acts at the grip point given at the attachment (between the jaws), so a
// rotation of the held object about it is opposed by the angular spring only.
//
// With a grip limit the child slips between the jaws: where the springs would exceed the limit, they stay on it, and
// the child's grip point and attitude go along. Along the jaws' axis, and about the others, the jaws hold by their
// shape. Tunables: stiffness_N_per_m, damping_N_s_per_m, stiffness_Nm_per_rad, damping_Nm_s_per_rad.
class SpringCoupling final : public Mechanism {
 public:
  explicit SpringCoupling(const SpringCouplingParams& params);

  // Holds the present relative pose; p_W is the grip point.
  void Attach(const core::Pose& X_WParent, const core::Pose& X_WChild, const glm::dvec3& p_W);
  void Detach();
  // Held until replaced; a grasp without one holds everything. First before the world is stepped: a checkpoint has it.
  void SetGripLimit(const GripLimit& limit) { limit_ = limit; }
  [[nodiscard]] bool is_attached() const { return is_attached_; }

  void Prepare(const BodyView& parent, const BodyView& child, double dt_s) override;
  void Finish(double dt_s) override;
  [[nodiscard]] double StoredEnergy_J(const BodyView& parent, const BodyView& child) const override;
  void ExchangeState(Checkpoint* checkpoint) override;

  // Wrench on the parent in the last step, about the origin of the parent's frame at the start of that step, in W.
  [[nodiscard]] const core::Wrench& F_Po_W() const { return F_Po_W_; }
  // Displacement of the child's grip point from the parent's, in the parent's axes [m].
  [[nodiscard]] const glm::dvec3& deflection_P_m() const { return deflection_P_m_; }

 private:
  [[nodiscard]] glm::dvec3 Offset_W(const BodyView& parent, const BodyView& child) const;
  [[nodiscard]] glm::dvec3 Turn_W(const BodyView& parent, const BodyView& child) const;

  void HoldEverything(const BodyView& parent, const BodyView& child);
  void Slip(const BodyView& parent, const BodyView& child);
  void HoldWithinLimit(const BodyView& parent, const BodyView& child, double dt_s);

  SpringCouplingParams params_;
  std::optional<GripLimit> limit_;
  bool is_attached_ = false;
  core::Pose X_PC_;
  glm::dvec3 p_PGrip_m_{0.0};
  glm::dvec3 p_CGrip_m_{0.0};
  glm::dvec3 p_WPo_{0.0};
  glm::dvec3 deflection_P_m_{0.0};
  core::Wrench F_Po_W_;
};

}  // namespace physics
