#pragma once

#include <array>
#include <cmath>
#include <glm/glm.hpp>

namespace physics::closed_form {

// Torque-free rotation of a body with three different principal moments [Landau and Lifshitz, Mechanics, 37]: the
// angular velocity in the body's principal axes at any time, without integration. With M the angular momentum, E the
// energy, moments A, B, C, B the middle one and C on that side of it on which M^2 / 2E lies,
//   w_A = a cn(u), w_B = b sn(u), w_C = c dn(u),  u = rate (t - t_0).
// Not for motion exactly on the separatrix M^2 = 2 E B, which has no period.
class FreeRotation {
 public:
  FreeRotation(const glm::dvec3& moments_kg_m2, const glm::dvec3& w_B_rad_per_s);

  // At time t after the start.
  [[nodiscard]] glm::dvec3 w_B_rad_per_s(double t_s) const;
  // After which w_B repeats; half of it lies between two flips.
  [[nodiscard]] double period_s() const { return period_s_; }
  // The n-th time after the start, n >= 0, at which the rate about the middle axis passes zero: a flip of that axis.
  [[nodiscard]] double flip_s(int n) const;

 private:
  std::array<int, 3> axes_{};  // of A, B, C
  double sign_ = 1.0;
  glm::dvec3 amplitudes_{0.0};
  double rate_ = 0.0;
  double complementary_modulus_ = 1.0;
  double start_ = 0.0;  // u at the start
  double period_s_ = 0.0;
};

// Force-free centre of mass.
inline glm::dvec3 DriftPosition(const glm::dvec3& p_W, const glm::dvec3& v_W, double t_s) {
  return {std::fma(v_W.x, t_s, p_W.x), std::fma(v_W.y, t_s, p_W.y), std::fma(v_W.z, t_s, p_W.z)};
}

}  // namespace physics::closed_form
