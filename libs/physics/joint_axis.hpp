#pragma once

#include <span>

#include "physics/row.hpp"

namespace physics {

// The free axis of a hinge (rad, Nm) or a slider (m, N): its limits, damping, motor and lock.
struct JointAxisParams {
  double lower = -1e9;
  double upper = 1e9;
  double damping = 0.0;      // Nm s/rad or N s/m
  double motor_speed = 0.0;  // target speed of the child relative to the parent, rad/s or m/s
  double motor_limit = 0.0;  // largest torque or force of the motor; 0: no motor
  double locked = 0.0;       // 1: held at its present position
  // A servo in place of the motor's speed: a spring to servo_target and a damper, by at most motor_limit. 0: none.
  double servo_stiffness = 0.0;  // Nm/rad or N/m
  double servo_damping = 0.0;
  double servo_target = 0.0;
};

// Part of a position error that a hard row removes per step: all of it, so that with the term of PointAcceleration the
// joint's anchors coincide at the end of each step (SHAKE) [Ryckaert, Ciccotti and Berendsen 1977].
constexpr double kErrorReduction = 1.0;

// Makes `row` hard: its relative speed at the end of the step is `bias`.
void SetHard(Row* row, const glm::dvec3& linear_W, const glm::dvec3& angular_W, const glm::dvec3& p_W, double bias);

// Acceleration [m/s^2] of a point fixed in a force-free body, r_W from its centre of mass: alpha x r + w x (w x r). A
// constraint at the end of the step must include dt^2 / 2 of it, else a moving joint has a gap of that size.
glm::dvec3 PointAcceleration(const BodyView& body, const glm::dvec3& r_W);

class JointAxis {
 public:
  static constexpr std::size_t kNumRows = 5;

  // Sets `rows`, kNumRows of them, for an axis along linear_W or about angular_W at p_W (one of the vectors is zero).
  // The first is soft and carries the damping; the owner may add a spring to it.
  void Prepare(const JointAxisParams& params, std::span<Row> rows, const glm::dvec3& linear_W,
               const glm::dvec3& angular_W, const glm::dvec3& p_W, double position, double dt_s);
  // Force or torque of the last step, along the axis on the child.
  static double Force(std::span<const Row> rows, double dt_s);
  void ExchangeState(Checkpoint* checkpoint);

 private:
  bool is_locked_ = false;
  double lock_position_ = 0.0;
};

}  // namespace physics
