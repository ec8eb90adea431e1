#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "hug/arm.hpp"
#include "hug/avoidance.hpp"

namespace hug {

enum class Side : std::uint8_t { kRight, kLeft };

// Where the two arms stand on HUG's base, x towards the operator, z up, and what stands around them. Only their
// lengths are published; distances are assumed.
struct MachineFigures {
  core::Pose X_WB;
  double between_arms_m = 0.6;
  bool has_bodies = true;  // column and operator
  Avoidance avoidance;
};

// A SIMULATED HUG: two arms and their clock.
class Machine {
 public:
  explicit Machine(const MachineFigures& figures);

  // Base of an arm in W.
  [[nodiscard]] core::Pose X_WB(Side side) const;
  // Puts an arm into service, before time passes; an arm without a role stands in its ready posture. False: the arm
  // does not reach its start.
  bool Open(Side side, ArmFigures figures, const core::Pose& X_WD_start);
  void Close(Side side) { in_service_[Index(side)] = false; }
  [[nodiscard]] bool is_open(Side side) const { return in_service_[Index(side)]; }

  // Brings both arms to the last step of the joint loop before now. A pause of more than 0.1 s is skipped.
  void AdvanceTo(std::int64_t now_ns);

  [[nodiscard]] Arm& arm(Side side) { return *arms_[Index(side)]; }
  [[nodiscard]] double least_distance_m() const { return least_m_; }  // between the arms, in this run
  [[nodiscard]] const MachineFigures& figures() const { return figures_; }

 private:
  static std::size_t Index(Side side) { return static_cast<std::size_t>(side); }
  void Sense();
  void Move();

  MachineFigures figures_;
  std::vector<Capsule> bodies_;
  std::array<std::optional<Arm>, 2> arms_;
  std::array<bool, 2> in_service_{};
  std::int64_t begin_ns_ = 0;
  std::int64_t num_steps_ = 0;
  bool is_begun_ = false;
  double least_m_ = 1e9;
};

}  // namespace hug
