#pragma once

#include <glm/glm.hpp>

#include "physics/mass_properties.hpp"

namespace physics {

// Spatial vectors and inertias [Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 2]. All are in world axes about
// one common point, so no transforms between links are needed.

struct Motion {  // velocity or acceleration
  glm::dvec3 angular{0.0};
  glm::dvec3 linear{0.0};  // of the body's point at the common point
};
struct Force {  // force or momentum
  glm::dvec3 torque{0.0};
  glm::dvec3 force{0.0};
};

inline Motion operator+(const Motion& a, const Motion& b) {
  return {a.angular + b.angular, a.linear + b.linear};
}
inline Motion operator*(double s, const Motion& a) {
  return {s * a.angular, s * a.linear};
}
inline Force operator+(const Force& a, const Force& b) {
  return {a.torque + b.torque, a.force + b.force};
}
inline Force operator-(const Force& a, const Force& b) {
  return {a.torque - b.torque, a.force - b.force};
}
inline Force operator*(double s, const Force& a) {
  return {s * a.torque, s * a.force};
}
inline double Dot(const Motion& m, const Force& f) {
  return glm::dot(m.angular, f.torque) + glm::dot(m.linear, f.force);
}
// v x m and v x* f [Featherstone 2008, Eq. 2.31, 2.32].
inline Motion Cross(const Motion& v, const Motion& m) {
  return {glm::cross(v.angular, m.angular), glm::cross(v.angular, m.linear) + glm::cross(v.linear, m.angular)};
}
inline Force Cross(const Motion& v, const Force& f) {
  return {glm::cross(v.angular, f.torque) + glm::cross(v.linear, f.force), glm::cross(v.angular, f.force)};
}

inline glm::dmat3 CrossMatrix(const glm::dvec3& r) {
  return {0.0, r.z, -r.y, -r.z, 0.0, r.x, r.y, -r.x, 0.0};  // by columns
}

// Symmetric 6x6 inertia, [torque; force] = [A B; B^T C] [angular; linear].
struct SpatialInertia {
  glm::dmat3 A{0.0};
  glm::dmat3 B{0.0};
  glm::dmat3 C{0.0};

  [[nodiscard]] Force operator*(const Motion& m) const {
    return {A * m.angular + B * m.linear, glm::transpose(B) * m.angular + C * m.linear};
  }
  SpatialInertia& operator+=(const SpatialInertia& other) {
    A += other.A;
    B += other.B;
    C += other.C;
    return *this;
  }
  // Subtracts U U^T / d.
  void Subtract(const Force& U, double d) {
    A -= glm::outerProduct(U.torque, U.torque) / d;
    B -= glm::outerProduct(U.torque, U.force) / d;
    C -= glm::outerProduct(U.force, U.force) / d;
  }
};

// Inertia of a rigid body with its centre of mass at c from the common point and inertia tensor I_Cm about it, in world
// axes [Featherstone 2008, Eq. 2.63]: A = I_Cm + m cx cx^T, B = m cx, C = m E.
inline SpatialInertia RigidInertia(double mass_kg, const glm::dvec3& c, const glm::dmat3& I_Cm_W) {
  const glm::dmat3 cx = CrossMatrix(c);
  return {I_Cm_W + mass_kg * cx * glm::transpose(cx), mass_kg * cx, glm::dmat3(mass_kg)};
}

// Solves I x = f for a positive definite I by the Schur complement of C:
//   (A - B C^-1 B^T) angular = torque - B C^-1 force,   linear = C^-1 (force - B^T angular).
inline Motion Solve(const SpatialInertia& I, const Force& f) {
  const glm::dmat3 C_inverse = glm::inverse(I.C);
  const glm::dmat3 schur = I.A - I.B * C_inverse * glm::transpose(I.B);
  const glm::dvec3 angular = glm::inverse(schur) * (f.torque - I.B * (C_inverse * f.force));
  return {angular, C_inverse * (f.force - glm::transpose(I.B) * angular)};
}

}  // namespace physics
