#include "physics/row.hpp"

namespace physics {

void Mechanism::SetSpring(Row* row, const glm::dvec3& axis_W, const glm::dvec3& p_W, double offset_m, double stiffness,
                          double damping) {
  row->is_active = true;
  row->is_hard = false;
  row->linear_W = axis_W;
  row->angular_W = glm::dvec3(0.0);
  row->p_W = p_W;
  row->force = -stiffness * offset_m;
  row->stiffness = stiffness;
  row->damping = damping;
  row->velocity_bias = 0.0;
}

void Mechanism::SetAngularSpring(Row* row, const glm::dvec3& axis_W, double angle_rad, double stiffness,
                                 double damping) {
  row->is_active = true;
  row->is_hard = false;
  row->linear_W = glm::dvec3(0.0);
  row->angular_W = axis_W;
  row->force = -stiffness * angle_rad;
  row->stiffness = stiffness;
  row->damping = damping;
  row->velocity_bias = 0.0;
}

}  // namespace physics
