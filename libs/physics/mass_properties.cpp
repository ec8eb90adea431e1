#include "physics/mass_properties.hpp"

#include <algorithm>
#include <cmath>

namespace physics {

PrincipalInertia DiagonalizeInertia(const glm::dmat3& I_O_kg_m2) {
  glm::dmat3 a = I_O_kg_m2;
  glm::dmat3 v(1.0);  // columns: eigenvectors
  // Jacobi's method converges quadratically: a 3x3 matrix needs 4 to 6 sweeps, so 32 is a bound that is never reached.
  for (int sweep = 0; sweep < 32; ++sweep) {
    const double off = std::abs(a[1][0]) + std::abs(a[2][0]) + std::abs(a[2][1]);
    const double scale = std::abs(a[0][0]) + std::abs(a[1][1]) + std::abs(a[2][2]);
    if (off <= 1e-15 * scale) break;
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        if (a[q][p] == 0.0) continue;
        // Rotation in the (p, q) plane that makes a_pq zero: tan(2 phi) = 2 a_pq / (a_qq - a_pp), smaller root.
        const double theta = (a[q][q] - a[p][p]) / (2.0 * a[q][p]);
        const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
        const double c = 1.0 / std::sqrt(t * t + 1.0);
        const double s = t * c;
        glm::dmat3 j(1.0);
        j[p][p] = c;
        j[q][q] = c;
        j[q][p] = s;  // glm: [column][row]
        j[p][q] = -s;
        a = glm::transpose(j) * a * j;
        v = v * j;
      }
    }
  }
  // A product of plane rotations is a proper rotation, so the quaternion exists.
  return {glm::normalize(glm::quat_cast(v)), {a[0][0], a[1][1], a[2][2]}};
}

bool IsPhysical(const MassProperties& properties) {
  if (!(properties.mass_kg > 0.0) || !std::isfinite(properties.mass_kg)) return false;
  if (!std::isfinite(glm::dot(properties.p_OCm_m, properties.p_OCm_m))) return false;
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) {
      if (!std::isfinite(properties.I_Cm_O_kg_m2[c][r])) return false;
    }
  }
  const glm::dvec3 m = DiagonalizeInertia(properties.I_Cm_O_kg_m2).moments_kg_m2;
  if (!(std::min({m.x, m.y, m.z}) > 0.0)) return false;
  const double largest = std::max({m.x, m.y, m.z});
  return m.x + m.y + m.z >= 2.0 * largest * (1.0 - 1e-9);
}

MassProperties BoxMass(double mass_kg, const glm::dvec3& size_m) {
  const glm::dvec3 s = size_m * size_m;
  MassProperties properties;
  properties.mass_kg = mass_kg;
  properties.I_Cm_O_kg_m2 = glm::dmat3(0.0);
  properties.I_Cm_O_kg_m2[0][0] = mass_kg / 12.0 * (s.y + s.z);
  properties.I_Cm_O_kg_m2[1][1] = mass_kg / 12.0 * (s.x + s.z);
  properties.I_Cm_O_kg_m2[2][2] = mass_kg / 12.0 * (s.x + s.y);
  return properties;
}

}  // namespace physics
