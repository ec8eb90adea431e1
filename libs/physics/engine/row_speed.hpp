#pragma once

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>

namespace physics {

// Contribution of one body's velocity to a row's speed, J v.
inline double Along(const btVector3& J_linear, const btVector3& J_angular, const btVector3& linear,
                    const btVector3& angular) {
  return J_linear.dot(linear) + J_angular.dot(angular);
}

}  // namespace physics
