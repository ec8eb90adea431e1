#pragma once

namespace physics::closed_form {

// Jacobi's elliptic functions and the elliptic integral of the first kind, by the arithmetic-geometric mean
// [Abramowitz and Stegun, 16.4, 17.6]. The modulus is given as its complement k' = sqrt(1 - k^2), 0 < k' <= 1: close to
// a separatrix k rounds to 1 while k' still has all its digits.
struct JacobiElliptic {
  double sn = 0.0;
  double cn = 1.0;
  double dn = 1.0;
};
JacobiElliptic EvaluateJacobi(double u, double complementary_modulus);

// K(k) = F(pi / 2, k): a quarter of the period of sn and cn.
double CompleteEllipticK(double complementary_modulus);

// F(phi, k) = integral from 0 to phi of dt / sqrt(1 - k^2 sin^2 t), any phi.
double IncompleteEllipticF(double phi_rad, double complementary_modulus);

}  // namespace physics::closed_form
