#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace vps {

// Grid of signed integer layers around a closed surface [VR-OOS, section 3, Fig. 5a]: voxels that the surface passes
// through hold 0, the k-th layer inside +k, the k-th layer outside -k, saturated at +-kMaxLayer.
//
// The k-th layer is made of the voxels whose centre's Euclidean distance to the nearest centre of a surface voxel,
// rounded, is k voxels. (The paper does not say how its layers are grown. Growing by 26 neighbours counts steps of
// different length: three layers deep behind a surface of normal (1,1,1) it is 1.5 voxels short.)
//
// Bytes: layers[(z * ny + y) * nx + x], x fastest; voxel (0,0,0) spans [origin, origin + voxel_size] in the mesh frame.
// The grid is padded by border_layers voxels on every side of the mesh's box. Points outside the grid are farther from
// the surface than that: kBorder_m covers the look-ahead of usual pairs (2 mm). The limits of 8 and 24 layers are not
// derived; more layers take memory, fewer make the bounds of far spheres shorter.
struct Voxmap {
  static constexpr int kMaxLayer = 127;
  static constexpr int kMinBorderLayers = 8;
  static constexpr int kMaxBorderLayers = 24;
  static constexpr double kBorder_m = 2.5e-3;

  glm::dvec3 origin_m{0.0};  // lower corner of the grid, mesh frame
  double voxel_size_m = 0.0;
  std::int32_t nx = 0, ny = 0, nz = 0;
  std::int32_t border_layers = 0;
  std::vector<std::int8_t> layers;

  [[nodiscard]] std::size_t num_voxels() const { return layers.size(); }
  [[nodiscard]] bool contains(int x, int y, int z) const {
    return x >= 0 && y >= 0 && z >= 0 && x < nx && y < ny && z < nz;
  }
  [[nodiscard]] std::int8_t at(int x, int y, int z) const {
    return layers[(static_cast<std::size_t>(z) * ny + y) * nx + x];
  }
};

}  // namespace vps
