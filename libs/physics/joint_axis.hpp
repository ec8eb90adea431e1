#pragma once

#include <span>

#include "physics/row.hpp"

namespace physics {

// The free axis of a hinge (rad, Nm) or a slider (m, N): what limits, brakes, drives and locks it.
struct JointAxisParams {
  double lower = -1e9;
  double upper = 1e9;
  double damping = 0.0;      // Nm s/rad or N s/m
  double motor_speed = 0.0;  // wanted, of the child against the parent, rad/s or m/s
  double motor_limit = 0.0;  // largest torque or force of the motor; 0: no motor
  double locked = 0.0;       // 1: held where it is
};

// Part of a position error that a hard row removes per step: all of it, so that with the bias of `Curvature` the
// joint's anchors are together at the end of each step (SHAKE, Ryckaert, Ciccotti and Berendsen 1977).
constexpr double kErrorReduction = 1.0;

// Makes `row` hard: the rows' relative speed at the end of the step is `bias`.
void SetHard(Row* row, const glm::dvec3& linear_W, const glm::dvec3& angular_W, const glm::dvec3& p_W, double bias);

// Acceleration of a point that is fixed in a body, r_W away from its centre of mass, that moves free of forces:
// alpha x r + w x (w x r). A constraint that is to hold at the end of the step must allow for dt^2 / 2 of it; without,
// a joint in motion gapes by that much.
glm::dvec3 PointAcceleration(const BodyView& body, const glm::dvec3& r_W);

class JointAxis {
 public:
  static constexpr std::size_t kNumRows = 5;

  // Sets `rows`, kNumRows of them, for an axis along linear_W or about angular_W at p_W (one of the vectors is zero).
  // The first is soft and carries the damping; the owner may add a spring to it.
  void Prepare(const JointAxisParams& params, std::span<Row> rows, const glm::dvec3& linear_W,
               const glm::dvec3& angular_W, const glm::dvec3& p_W, double position, double dt_s);
  // Of the last step, along the axis on the child.
  static double Force(std::span<const Row> rows, double dt_s);
  void ExchangeState(Checkpoint* checkpoint);

 private:
  bool is_locked_ = false;
  double lock_position_ = 0.0;
};

}  // namespace physics
