#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/pose.hpp"
#include "vps/tree/point_tree.hpp"
#include "vps/voxmap/voxmap.hpp"

namespace vps {

// A point of S with V(P) >= -margin; V(P) of Eq. 1, positive inside.
struct PointHit {
  std::uint32_t point = 0;  // index in the tree
  float penetration_m = 0.0f;
};

// Memory of one pair's queries, allocated once. hits[0, num_hits) is the result, by ascending point index.
struct QueryScratch {
  explicit QueryScratch(const PointTree& tree) { MakeRoomFor(tree); }
  void MakeRoomFor(const PointTree& tree) {
    queue.resize(std::max(queue.size(), tree.clusters.size() + PointTree::kPadding));
    hits.resize(std::max(hits.size(), std::size_t{tree.num_points} + PointTree::kPadding));
  }
  std::vector<std::uint32_t> queue;
  std::vector<PointHit> hits;
};

struct QueryResult {
  std::uint32_t num_hits = 0;       // V >= -margin
  std::uint32_t num_colliding = 0;  // V >= 0
  std::uint32_t spheres_tested = 0;
  std::uint32_t points_tested = 0;
  float max_penetration_m = -1e30f;  // of the hits
  // No hit: S may move by this much, every point of it, before one can appear. 0: no such bound. With hits: 0.
  double free_distance_m = 0.0;
};

// Breadth-first walk of the point-sphere tree with a FIFO queue [VR-OOS, Fig. 6]: a cluster whose sphere can hold a
// point with V >= -margin is queued, the points of a leaf are tested. Finds exactly the points that testing every
// point finds. Two differences from the figure change no result: a sphere is tested when its cluster would be queued,
// not when it is popped (the children of a cluster stand side by side and are tested four at a time), and the parent
// points of inner clusters, each of which is also in a leaf, are tested only there.
//
// Spheres: let D be the distance in voxels between the centres of c's voxel and the nearest surface voxel, layer
// |v| <= D + 1/2. A hit lies in a voxel with |v| <= m, D <= m + 1/2 (m: OutermostLayer). D changes by no more than the
// distance of two voxel centres, which is at most |P - c| + 2 sqrt(3)/2. So no hit is closer to c than
// |v| - m - 1 - 1.7321 voxels; the sphere is skipped when its radius is less. Outside the grid the distance to the
// surface voxels' box takes the place of |v| - 1/2.
//
// `sampled` is S's tree, `field` G's grid, X_GS the pose of S in G, margin_m >= 0 the look-ahead. The result is
// complete; nothing is allocated.
QueryResult QueryTree(const PointTree& sampled, const Voxmap& field, const core::Pose& X_GS, double margin_m,
                      QueryScratch* scratch);

}  // namespace vps
