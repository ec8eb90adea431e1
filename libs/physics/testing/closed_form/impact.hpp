#pragma once

#include <glm/glm.hpp>

namespace physics::closed_form {

// One body in an impact, everything in W.
struct ImpactBody {
  double inverse_mass_per_kg = 0.0;  // 0: cannot move
  glm::dmat3 inverse_inertia_W{0.0};
  glm::dvec3 p_CmC_W{0.0};  // from the centre of mass to the contact point
  glm::dvec3 v_Cm_W{0.0};
  glm::dvec3 w_W{0.0};
};

// Frictionless impact of two bodies at one point with Newton's law of restitution; n points from b to a. Returns the
// impulse on a along n in N s, 0 when they do not approach, and changes the velocities. With v_n the speed of approach,
//   J = -(1 + e) v_n / (n . (1/m_a + 1/m_b) n + (r_a x n) . I_a^-1 (r_a x n) + (r_b x n) . I_b^-1 (r_b x n)).
double Impact(ImpactBody* a, ImpactBody* b, const glm::dvec3& n_W, double restitution);

}  // namespace physics::closed_form
