#pragma once

#include <cstdint>

#include "core/messages/haptic.hpp"

namespace collision {

// Adds a pair that touches. When the list is full the deepest stay.
void AddCollision(const core::Collision& collision, core::CollisionMatrix* matrix);

// The entry of two objects, in either order; null when they do not touch. With several pairs between them, the deepest.
const core::Collision* FindCollision(const core::CollisionMatrix& matrix, std::uint16_t object_a,
                                     std::uint16_t object_b);

inline bool AreColliding(const core::CollisionMatrix& matrix, std::uint16_t object_a, std::uint16_t object_b) {
  return FindCollision(matrix, object_a, object_b) != nullptr;
}

}  // namespace collision
