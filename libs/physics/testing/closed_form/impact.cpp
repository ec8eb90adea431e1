#include "physics/testing/closed_form/impact.hpp"

namespace physics::closed_form {
namespace {

double InverseEffectiveMass(const ImpactBody& body, const glm::dvec3& n_W) {
  const glm::dvec3 lever = glm::cross(body.p_CmC_W, n_W);
  return body.inverse_mass_per_kg + glm::dot(lever, body.inverse_inertia_W * lever);
}

void Push(ImpactBody* body, const glm::dvec3& impulse_W) {
  body->v_Cm_W += body->inverse_mass_per_kg * impulse_W;
  body->w_W += body->inverse_inertia_W * glm::cross(body->p_CmC_W, impulse_W);
}

}  // namespace

double Impact(ImpactBody* a, ImpactBody* b, const glm::dvec3& n_W, double restitution) {
  const glm::dvec3 v_a = a->v_Cm_W + glm::cross(a->w_W, a->p_CmC_W);
  const glm::dvec3 v_b = b->v_Cm_W + glm::cross(b->w_W, b->p_CmC_W);
  const double v_n = glm::dot(n_W, v_a - v_b);
  if (v_n >= 0.0) return 0.0;
  const double impulse_Ns =
      -(1.0 + restitution) * v_n / (InverseEffectiveMass(*a, n_W) + InverseEffectiveMass(*b, n_W));
  Push(a, impulse_Ns * n_W);
  Push(b, -impulse_Ns * n_W);
  return impulse_Ns;
}

}  // namespace physics::closed_form
