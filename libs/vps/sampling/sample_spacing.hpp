#pragma once

#include <cstdint>
#include <vector>

#include "vps/sampling/segment_tree.hpp"
#include "vps/sampling/sharp_edges.hpp"

namespace vps {

// Spacing of samples h(p) [m]: the square root of a sample's weight (area) there. Even on faces; towards sharp edges it
// shrinks in proportion to the distance from them, down to `edge_m`, and along an edge towards its corners down to
// `corner_m` (decision 7):
//   h = clamp(d_edge, floor, face),  floor = clamp(d_corner / 2, corner, edge).
// So |h(p) - h(q)| <= |p - q|.
class SampleSpacing {
 public:
  // Such that about `num_points` points fit the area, with up to kEdgeShare of them spent at edges and corners.
  SampleSpacing(const TriangleMesh& mesh, double area_m2, std::uint32_t num_points);

  // Decision 7 measured 0.4 and 0.5 on the module; the finest spacings it states are not derived.
  static constexpr double kEdgeShare = 0.5;
  static constexpr double kFinestEdge = 1.0 / 16.0;    // of the face's spacing
  static constexpr double kFinestCorner = 1.0 / 16.0;  // of the edge's

  // Edges and corners that may matter to places in a box; narrowed down while the surface is divided.
  struct Nearby {
    SegmentTree::Nearby edges, corners;
    [[nodiscard]] bool is_empty() const { return edges.is_empty() && corners.is_empty(); }
  };
  [[nodiscard]] Nearby Around(const Box& box) const;
  // Distances to the nearest edge and corner, infinite where none is near.
  struct Distances {
    double edge_m, corner_m;
  };
  // `radius_m`: about p, of the piece of surface that is asked for: At() takes no more than that from them.
  [[nodiscard]] Distances To(const glm::dvec3& p, const Nearby& nearby, double radius_m) const;
  // Those that may matter within a radius of the centre, whose distances are given. `nearby` has to outlive them.
  [[nodiscard]] Nearby Narrow(const Nearby& nearby, const glm::dvec3& centre, double radius_m,
                              const Distances& distances) const;
  // h at a place with these distances, all edges and corners taken `less_m` nearer: a lower bound within that distance
  // of the place.
  [[nodiscard]] double At(const Distances& distances, double less_m = 0.0) const;

  [[nodiscard]] double face_m() const { return face_m_; }
  [[nodiscard]] double edge_m() const { return edge_m_; }

 private:
  SampleSpacing(const SharpEdges& sharp, double area_m2, std::uint32_t num_points);

  SegmentTree edges_, corners_;
  double face_m_ = 0.0, edge_m_ = 0.0, corner_m_ = 0.0;
};

}  // namespace vps
