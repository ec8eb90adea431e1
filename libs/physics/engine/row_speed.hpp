#pragma once

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>

namespace physics {

// Part of a row's speed that is due to one body's velocity.
inline double Along(const btVector3& J_linear, const btVector3& J_angular, const btVector3& linear,
                    const btVector3& angular) {
  return J_linear.dot(linear) + J_angular.dot(angular);
}

}  // namespace physics
