#include "collision/collision_matrix.hpp"

#include <algorithm>

namespace collision {

void AddCollision(const core::Collision& collision, core::CollisionMatrix* matrix) {
  ++matrix->num_touching;
  auto& list = matrix->collisions;
  if (list.size() < core::kMaxCollisions) {
    list.push_back(collision);
    return;
  }
  const auto shallowest =
      std::min_element(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.depth_m < b.depth_m; });
  if (shallowest->depth_m < collision.depth_m) *shallowest = collision;
}

const core::Collision* FindCollision(const core::CollisionMatrix& matrix, std::uint16_t object_a,
                                     std::uint16_t object_b) {
  const core::Collision* found = nullptr;
  for (const core::Collision& c : matrix.collisions) {
    const bool is_theirs = (c.sampled_body == object_a && c.field_body == object_b) ||
                           (c.sampled_body == object_b && c.field_body == object_a);
    if (is_theirs && (found == nullptr || c.depth_m > found->depth_m)) found = &c;
  }
  return found;
}

}  // namespace collision
