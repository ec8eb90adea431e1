#include "physics/testing/closed_form/free_rotation.hpp"

#include <algorithm>
#include <cmath>

#include "physics/testing/closed_form/jacobi_elliptic.hpp"

namespace physics::closed_form {

FreeRotation::FreeRotation(const glm::dvec3& moments_kg_m2, const glm::dvec3& w_B_rad_per_s) {
  axes_ = {0, 1, 2};
  std::sort(axes_.begin(), axes_.end(), [&](int i, int j) { return moments_kg_m2[i] < moments_kg_m2[j]; });
  glm::dvec3 I(moments_kg_m2[axes_[0]], moments_kg_m2[axes_[1]], moments_kg_m2[axes_[2]]);
  glm::dvec3 w(w_B_rad_per_s[axes_[0]], w_B_rad_per_s[axes_[1]], w_B_rad_per_s[axes_[2]]);
  // M^2 - 2 E B, and below M^2 - 2 E A and 2 E C - M^2, from sums of squares: exact close to the separatrix.
  if (I.x * (I.x - I.y) * w.x * w.x + I.z * (I.z - I.y) * w.z * w.z < 0.0) {
    std::swap(axes_[0], axes_[2]);
    std::swap(I.x, I.z);
    std::swap(w.x, w.z);
  }
  const double above_A = std::abs(I.y * (I.y - I.x) * w.y * w.y + I.z * (I.z - I.x) * w.z * w.z);
  const double above_B = std::abs(I.x * (I.x - I.y) * w.x * w.x + I.z * (I.z - I.y) * w.z * w.z);
  const double below_C = std::abs(I.x * (I.z - I.x) * w.x * w.x + I.y * (I.z - I.y) * w.y * w.y);
  const double A_B = std::abs(I.y - I.x);
  const double B_C = std::abs(I.z - I.y);
  const double A_C = A_B + B_C;
  amplitudes_ = {std::sqrt(below_C / (I.x * A_C)), std::sqrt(below_C / (I.y * B_C)), std::sqrt(above_A / (I.z * A_C))};
  rate_ = std::sqrt(B_C * above_A / (I.x * I.y * I.z));
  complementary_modulus_ = std::sqrt(A_C * above_B / (B_C * above_A));  // k^2 = (B - A) (2EC - M^2) / (same)

  // cn' = -sn dn, sn' = cn dn, dn' = -k^2 sn cn, while Euler's equations for axes in the order A, B, C are
  // A w_A' = s (B - C) w_B w_C with s = +-1 the parity of that order. So -s sgn(B - C) w is the motion written above,
  // up to a change of sign of w_A and w_C together, which leaves Euler's equations as they are.
  const int parity = (axes_[1] - axes_[0] + 3) % 3 == 1 ? 1 : -1;
  sign_ = (I.y < I.z ? 1.0 : -1.0) * parity;
  const glm::dvec3 u = sign_ * w;
  if (u.z < 0.0) {
    amplitudes_.x = -amplitudes_.x;
    amplitudes_.z = -amplitudes_.z;
  }
  start_ = IncompleteEllipticF(std::atan2(u.y / amplitudes_.y, u.x / amplitudes_.x), complementary_modulus_);
  period_s_ = 4.0 * CompleteEllipticK(complementary_modulus_) / rate_;
}

glm::dvec3 FreeRotation::w_B_rad_per_s(double t_s) const {
  const JacobiElliptic f = EvaluateJacobi(start_ + rate_ * t_s, complementary_modulus_);
  glm::dvec3 w(0.0);
  w[axes_[0]] = sign_ * amplitudes_.x * f.cn;
  w[axes_[1]] = sign_ * amplitudes_.y * f.sn;
  w[axes_[2]] = sign_ * amplitudes_.z * f.dn;
  return w;
}

double FreeRotation::flip_s(int n) const {
  // sn(u) = 0 at u = 2 K i.
  const double half = 2.0 * CompleteEllipticK(complementary_modulus_);
  return (half * (std::floor(start_ / half) + 1.0 + n) - start_) / rate_;
}

}  // namespace physics::closed_form
