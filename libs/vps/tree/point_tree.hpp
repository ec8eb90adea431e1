#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace vps {

// One cluster of the point-sphere tree [VR-OOS, Fig. 6]: a sphere that holds every point below, the parent point, and
// up to four children, which stand side by side: clusters when inner, points when a leaf. 32 bytes.
struct Cluster {
  float centre_m[3] = {0, 0, 0};  // mesh frame
  float radius_m = 0.0f;          // padded against rounding
  std::uint32_t first_child = 0;  // index of the first child cluster, or of the first point of a leaf
  std::uint8_t num_children = 0;
  std::uint8_t is_leaf = 0;
  std::uint16_t reserved = 0;
  std::uint32_t parent_point = 0;  // index of the cluster's parent point
  std::uint32_t num_points = 0;    // of all descendants
};
static_assert(sizeof(Cluster) == 32);

// Pointshell in tree order. Arrays are padded by kPadding entries so that kernels may read whole groups of four.
struct PointTree {
  static constexpr std::size_t kPadding = 4;

  std::uint32_t num_points = 0;
  std::vector<float> x, y, z;     // positions, mesh frame, m
  std::vector<float> nx, ny, nz;  // unit inward normals
  std::vector<Cluster> clusters;  // breadth-first; [0] is the root
};

}  // namespace vps
