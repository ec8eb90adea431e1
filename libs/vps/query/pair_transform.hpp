#pragma once

#include <cmath>

#include "core/pose.hpp"
#include "vps/voxmap/voxmap.hpp"

namespace vps {

// From S's mesh frame to G's voxel units (voxel (i,j,k) spans [i,i+1] x ...), formed in double once per query; the
// kernels run in float. At 1000 voxels a float resolves 6e-5 voxel.
struct PairTransform {
  float m[3][3];  // R_GS / s
  float r[3][3];  // R_GS
  float t[3];
  float voxel_size_m;

  PairTransform(const core::Pose& X_GS, const Voxmap& field) {
    const glm::dmat3 R = glm::mat3_cast(X_GS.rotation);  // column major
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        r[row][column] = static_cast<float>(R[column][row]);
        m[row][column] = static_cast<float>(R[column][row] / field.voxel_size_m);
      }
      t[row] = static_cast<float>((X_GS.translation[row] - field.origin_m[row]) / field.voxel_size_m);
    }
    voxel_size_m = static_cast<float>(field.voxel_size_m);
  }
  [[nodiscard]] glm::vec3 ToVoxels(const glm::vec3& p_S) const {
    return {m[0][0] * p_S.x + m[0][1] * p_S.y + m[0][2] * p_S.z + t[0],
            m[1][0] * p_S.x + m[1][1] * p_S.y + m[1][2] * p_S.z + t[1],
            m[2][0] * p_S.x + m[2][1] * p_S.y + m[2][2] * p_S.z + t[2]};
  }
};

// Layers, counted outwards, that a point with V >= -margin can be in: V = v s + n . e with |n . e| <= sqrt(3)/2 s.
inline int OutermostLayer(double margin_m, double voxel_size_m) {
  return static_cast<int>(std::floor(margin_m / voxel_size_m + 0.8661));
}

}  // namespace vps
