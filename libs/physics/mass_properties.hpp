#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

namespace physics {

// Mass distribution of a rigid body, in the axes of its mesh frame O.
struct MassProperties {
  double mass_kg = 1.0;
  glm::dvec3 p_OCm_m{0.0};       // centre of mass
  glm::dmat3 I_Cm_O_kg_m2{1.0};  // inertia tensor about the centre of mass, symmetric
};

// Principal axes of an inertia tensor: I_O = R_OB diag(moments) R_OB^T.
struct PrincipalInertia {
  glm::dquat R_OB{1.0, 0.0, 0.0, 0.0};
  glm::dvec3 moments_kg_m2{1.0};
};

// By cyclic Jacobi rotations. A diagonal tensor keeps its axes, so an axis-aligned body stays axis-aligned bit for bit.
PrincipalInertia DiagonalizeInertia(const glm::dmat3& I_O_kg_m2);

// Whether a real body can have these properties: finite, with positive moments that satisfy the triangle inequality.
bool IsPhysical(const MassProperties& properties);

// Homogeneous box with edges along the axes, centred at the origin; for tests and for parts without a mesh.
MassProperties BoxMass(double mass_kg, const glm::dvec3& size_m);

}  // namespace physics
