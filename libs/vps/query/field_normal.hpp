#pragma once

#include "vps/query/pair_transform.hpp"
#include "vps/voxmap/voxmap.hpp"

namespace vps {

// Direction in which the layers of G fall, that is out of G, at a point in voxel units: the derivative of a contact's
// gap with respect to the point, which is what a contact plane needs (the point's own normal, which Eq. 1 uses, is 45
// degrees off when an edge of S touches a face of G). Per axis the least-squares slope of the layers v over three
// voxels to each side, which averages their rounding:
//
//   slope = sum over k = 1 ... 3 of k (v(-k) - v(k)) / 28,   28 = 2 (1 + 4 + 9).
//
// Returns false where the field has no direction (middle of a slot, beyond the last layer: a slope below 0.3, not
// derived) or near the border of the grid.
inline bool FieldNormal(const Voxmap& field, const float p[3], glm::vec3* n_G) {
  constexpr int kReach = 3;
  const int x = static_cast<int>(p[0]);
  const int y = static_cast<int>(p[1]);
  const int z = static_cast<int>(p[2]);
  if (x < kReach || y < kReach || z < kReach || x >= field.nx - kReach || y >= field.ny - kReach ||
      z >= field.nz - kReach) {
    return false;
  }
  const std::ptrdiff_t steps[3] = {1, field.nx, static_cast<std::ptrdiff_t>(field.nx) * field.ny};
  const std::int8_t* const home = field.layers.data() + x * steps[0] + y * steps[1] + z * steps[2];
  int slope[3] = {0, 0, 0};
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 1; k <= kReach; ++k) slope[axis] += k * (home[-k * steps[axis]] - home[k * steps[axis]]);
  }
  const glm::vec3 n(static_cast<float>(slope[0]), static_cast<float>(slope[1]), static_cast<float>(slope[2]));
  const float length = glm::length(n);
  if (length < 0.3f * 28.0f) return false;
  *n_G = n / length;
  return true;
}

}  // namespace vps
