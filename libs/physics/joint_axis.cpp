#include "physics/joint_axis.hpp"

#include <algorithm>

namespace physics {
namespace {

enum AxisRow : std::size_t { kPassive, kLower, kUpper, kMotor, kLock };

}  // namespace

void SetHard(Row* row, const glm::dvec3& linear_W, const glm::dvec3& angular_W, const glm::dvec3& p_W, double bias) {
  row->is_active = true;
  row->is_hard = true;
  row->linear_W = linear_W;
  row->angular_W = angular_W;
  row->p_W = p_W;
  row->velocity_bias = bias;
}

glm::dvec3 PointAcceleration(const BodyView& body, const glm::dvec3& r_W) {
  const glm::dvec3& w_W = body.V_WO.angular_rad_per_s;
  return glm::cross(body.alpha_W, r_W) + glm::cross(w_W, glm::cross(w_W, r_W));
}

void JointAxis::Prepare(const JointAxisParams& params, std::span<Row> rows, const glm::dvec3& linear_W,
                        const glm::dvec3& angular_W, const glm::dvec3& p_W, double position, double dt_s) {
  Row& passive = rows[kPassive];
  passive.is_active = params.damping > 0.0;
  passive.is_hard = false;
  passive.linear_W = linear_W;
  passive.angular_W = angular_W;
  passive.p_W = p_W;
  passive.force = 0.0;
  passive.stiffness = 0.0;
  passive.damping = params.damping;

  // Limits: lower <= position <= upper at the end of the step, by a row that only pushes inwards. Its speed condition
  // v >= -distance / dt stops the approach in time and removes a violation. The row is inactive while the limit is
  // farther away than one step at `speed` [rad/s or m/s], which is 10 per s at 1 ms: chosen, above any motion in use.
  const double speed = std::max(1.0, 1e-2 / dt_s);
  const auto limit = [&](Row* row, double sign, double inside) {
    SetHard(row, sign * linear_W, sign * angular_W, p_W, -inside / dt_s);
    row->lower = 0.0;
    row->is_active = inside < speed * dt_s;
  };
  limit(&rows[kLower], 1.0, position - params.lower);
  limit(&rows[kUpper], -1.0, params.upper - position);

  const bool is_locked = params.locked != 0.0;
  if (is_locked && !is_locked_) lock_position_ = position;
  is_locked_ = is_locked;
  SetHard(&rows[kLock], linear_W, angular_W, p_W, -kErrorReduction / dt_s * (position - lock_position_));
  rows[kLock].is_active = is_locked;

  SetHard(&rows[kMotor], linear_W, angular_W, p_W, params.motor_speed);
  rows[kMotor].is_active = params.motor_limit > 0.0 && !is_locked;  // redundant rows would have no unique solution
  rows[kMotor].lower = -params.motor_limit;
  rows[kMotor].upper = params.motor_limit;
  if (params.servo_stiffness <= 0.0) return;
  // T = k (q* - q) - (k dt + d) q' with q' at the end of the step, |T| <= limit: a spring that the motor cannot exceed.
  rows[kMotor].is_hard = false;
  rows[kMotor].force = params.servo_stiffness * (params.servo_target - position);
  rows[kMotor].stiffness = params.servo_stiffness;
  rows[kMotor].damping = params.servo_damping;
}

double JointAxis::Force(std::span<const Row> rows, double dt_s) {
  return (rows[kPassive].impulse + rows[kLower].impulse - rows[kUpper].impulse + rows[kMotor].impulse +
          rows[kLock].impulse) /
         dt_s;
}

void JointAxis::ExchangeState(Checkpoint* checkpoint) {
  checkpoint->Exchange(&is_locked_);
  checkpoint->Exchange(&lock_position_);
}

}  // namespace physics
