#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "core/pose.hpp"
#include "core/wrench.hpp"
#include "physics/checkpoint.hpp"
#include "physics/live_change.hpp"

namespace physics {

// Constraint row: one scalar line of action between a child and a parent. A force along `linear_W` at the common point
// `p_W` and a torque along `angular_W` act on the child, the opposite on the parent at the same point, so momentum is
// conserved.
//
// Soft row, with v the relative speed along the row (child minus parent) at the end of the step of length dt:
//   F = force - (stiffness dt + damping) v
// an implicit spring and damper: `force` is the spring's force at the start of the step and `stiffness` its slope, so F
// is the force at the end. It is stable for every mass; an explicit spring would need k dt^2 < 4 m (k dt^2 is 0.2 kg
// for 200 kN/m at 1 ms).
// Hard row: v = `velocity_bias` at the end of the step, by any force within the limits.
struct Row {
  bool is_active = false;
  bool is_hard = false;
  glm::dvec3 linear_W{0.0};
  glm::dvec3 angular_W{0.0};
  glm::dvec3 p_W{0.0};
  double force = 0.0;      // N, or Nm for an angular row
  double stiffness = 0.0;  // >= 0; a falling force profile is explicit instead
  double damping = 0.0;
  double velocity_bias = 0.0;
  double lower = -1e30;  // limits of the force
  double upper = 1e30;
  double impulse = 0.0;  // result of the last step and warm start of the next; 0 when the row was inactive
};

struct BodyView {
  core::Pose X_WO;
  core::Twist V_WO;
  glm::dvec3 p_WCm{0.0};    // centre of mass
  glm::dvec3 alpha_W{0.0};  // angular acceleration without torque: I^-1 (L x w)
};

// Exerts forces between two bodies by constraint rows. Prepare sets the rows from the poses at the start of the step,
// Finish reads the impulses. Neither allocates.
class Mechanism {
 public:
  explicit Mechanism(std::size_t num_rows) : rows_(num_rows) {}
  virtual ~Mechanism() = default;
  Mechanism(const Mechanism&) = delete;
  Mechanism& operator=(const Mechanism&) = delete;

  virtual void Prepare(const BodyView& parent, const BodyView& child, double dt_s) = 0;
  virtual void Finish(double dt_s) = 0;

  // Potential energy [J] of its springs at these poses, in its present state.
  [[nodiscard]] virtual double StoredEnergy_J(const BodyView& /*parent*/, const BodyView& /*child*/) const {
    return 0.0;
  }

  // Values that can be changed at run time. A newer change of the same value replaces one in progress.
  [[nodiscard]] const std::vector<Tunable>& tunables() const { return tunables_; }
  // Between steps; `next_tick` is the number of the coming step. An immediate change is complete on return.
  const ChangeReport& BeginChange(std::size_t tunable, const Change& change, const BodyView& parent,
                                  const BodyView& child, std::uint64_t next_tick);
  // At the start of step `tick`: advances ramps and applies held changes whose condition is satisfied.
  void AdvanceChanges(const BodyView& parent, const BodyView& child, std::uint64_t tick, double dt_s);

  // The complete state between steps, including the tunable values.
  virtual void ExchangeState(Checkpoint* checkpoint) {
    for (Row& row : rows_) checkpoint->Exchange(&row);
    for (Tunable& tunable : tunables_) tunable.ExchangeState(checkpoint);
    checkpoint->Exchange(&state_);
    checkpoint->Exchange(&position_);
    checkpoint->Exchange(&force_);
  }

  std::vector<Row>& rows() { return rows_; }
  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }

  // As core::MechanismState.
  [[nodiscard]] int state() const { return state_; }
  [[nodiscard]] double position() const { return position_; }
  [[nodiscard]] double force() const { return force_; }

 protected:
  void DeactivateAll() {
    for (Row& row : rows_) row.is_active = false;
  }
  // Linear spring along axis_W at p_W; `offset` is the child's displacement along the axis.
  static void SetSpring(Row* row, const glm::dvec3& axis_W, const glm::dvec3& p_W, double offset_m, double stiffness,
                        double damping);
  static void SetAngularSpring(Row* row, const glm::dvec3& axis_W, double angle_rad, double stiffness, double damping);

  // For constructors: declares a value that can be changed at run time.
  void AddTunable(const char* name, double* value, bool is_signed = false) {
    tunables_.push_back({name, value, is_signed, {}});
  }

  int state_ = 0;
  double position_ = 0.0;
  double force_ = 0.0;

 private:
  void SetValue(Tunable* tunable, double value, const BodyView& parent, const BodyView& child, std::uint64_t tick);

  std::vector<Row> rows_;
  std::vector<Tunable> tunables_;
};

}  // namespace physics
