#pragma once

#include <LinearMath/btTransform.h>

#include "core/pose.hpp"

// For use inside libs/physics only: no Bullet type appears in a public header.
namespace physics {

inline btVector3 ToBullet(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}
inline glm::dvec3 FromBullet(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}
inline btTransform ToBullet(const core::Pose& X) {
  return btTransform(btQuaternion(X.rotation.x, X.rotation.y, X.rotation.z, X.rotation.w), ToBullet(X.translation));
}

}  // namespace physics
