#include "tools/contact/methods/apart_bound.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

namespace contact {
namespace {

// Bound of the rounding of a stored distance [voxels]: 1/512 in the band (field_word.hpp), 2^-15 of the distance in the
// coarse grid, which is 0.02 at 650 voxels.
constexpr float kRounding = 0.02f;
// Bound of the error of fitted planes [voxels]: at most 0.3 is measured (DistanceField.NearTheSurface*); the rest is a
// margin that is not derived.
constexpr float kWorstInBand = 0.5f;

struct Centre {
  float distance;    // signed, at the centre [voxels]; -1e30 inside the band
  glm::vec3 centre;  // [voxels]
};
// Of the coarse cell that holds p.
Centre CentreOf(const vps::DistanceField& field, const glm::vec3& p) {
  const vps::FieldSample sample = vps::SampleField(field, p);
  return {sample.cell > 1.0f ? sample.centre_distance : -1e30f, (glm::floor(p / sample.cell) + 0.5f) * sample.cell};
}

}  // namespace

float LowerBoundOfDistance(const vps::DistanceField& field, const glm::vec3& p) {
  const vps::FieldSample sample = vps::SampleField(field, p);
  const glm::vec3 last(static_cast<float>(field.nx) - 0.5f, static_cast<float>(field.ny) - 0.5f,
                       static_cast<float>(field.nz) - 0.5f);
  const glm::vec3 q = glm::clamp(p, glm::vec3(0.0f), last);
  const bool is_in_band = sample.cell == 1.0f;
  const bool is_crease = is_in_band && sample.centre_offset == 0.0f;
  // Distance is 1-Lipschitz: d(q) >= d(c) - |q - c| for the cell's centre c.
  float least = is_crease ? -1e30f : sample.centre_distance - sample.centre_offset - kRounding;
  if (is_in_band) least = std::max(least, sample.distance - kWorstInBand);
  // The same from cells farther out along the gradient. From a centre at a along and l across it the bound loses
  // sqrt(a^2 + l^2) - a <= l^2 / (2 a), less the farther the centre.
  if (!is_in_band) {
    for (const float ahead : {1.0f, 2.0f, 4.0f, 8.0f}) {
      const glm::vec3 at = q + ahead * sample.cell * glm::normalize(sample.gradient);
      if (at != glm::clamp(at, glm::vec3(0.0f), last)) break;
      const Centre farther = CentreOf(field, at);
      least = std::max(least, farther.distance - glm::length(q - farther.centre) - kRounding);
    }
  }
  if (p == q) return least;
  // p is outside the grid, q its nearest place there. The surface keeps kMinBorder voxels from the grid's faces, so
  // d(p) is at least the distance to that smaller box. And the grid is convex: for x on the surface the angle at q
  // between p and x is at least 90 degrees, so |p - x|^2 >= |p - q|^2 + |q - x|^2.
  const glm::vec3 border(static_cast<float>(vps::DistanceField::kMinBorder) - 0.5f);
  const float to_box = glm::length(p - glm::clamp(p, border, last - border));
  return std::max(to_box, std::hypot(glm::length(p - q), std::max(least, 0.0f)));
}

namespace {

// A part of S with a lower bound of its distance from G.
struct NearPart {
  double bound_m = 0.0;
  vps::SurfaceNode node;
  vps::SurfacePiece triangle;  // of a leaf

  // std::priority_queue takes the greatest: the nearest part.
  bool operator<(const NearPart& other) const { return bound_m > other.bound_m; }
};

}  // namespace

double ApartBound_m(const vps::SurfaceTree& S, const vps::DistanceField& G, const core::Pose& X_GS) {
  constexpr int kMostParts = 20'000;  // not derived: a millisecond
  constexpr double kTolerance = 0.02;
  std::priority_queue<NearPart> parts;
  const auto offer = [&](const vps::SurfaceNode& node, const vps::SurfacePiece& triangle) {
    const glm::vec3 p((X_GS * glm::dvec3(node.centre_m) - G.origin_m) / G.voxel_size_m);
    const double distance_m = static_cast<double>(LowerBoundOfDistance(G, p)) * G.voxel_size_m;
    parts.push({distance_m - static_cast<double>(node.radius_m), node, triangle});
  };
  const auto offer_node = [&](std::uint32_t i) {
    const vps::SurfaceNode& node = S.nodes[i];
    offer(node, node.num_children == 0 ? S.triangles[node.first] : vps::SurfacePiece{});
  };
  for (std::uint32_t i = 0; i < S.num_roots; ++i) offer_node(i);
  for (int n = 0; n < kMostParts; ++n) {
    const NearPart nearest = parts.top();
    const auto radius_m = static_cast<double>(nearest.node.radius_m);
    if (radius_m < kTolerance * (nearest.bound_m + radius_m)) break;
    parts.pop();
    if (nearest.node.num_children > 0) {
      for (std::uint32_t i = 0; i < nearest.node.num_children; ++i) offer_node(nearest.node.first + i);
      continue;
    }
    const auto& [a, b, c] = nearest.triangle.corners;
    const glm::vec3 ab = 0.5f * (a + b);
    const glm::vec3 bc = 0.5f * (b + c);
    const glm::vec3 ca = 0.5f * (c + a);
    for (const vps::SurfacePiece& part : {vps::SurfacePiece{{a, ab, ca}}, vps::SurfacePiece{{ab, b, bc}},
                                          vps::SurfacePiece{{ca, bc, c}}, vps::SurfacePiece{{bc, ca, ab}}}) {
      offer(vps::NodeOf(part), part);
    }
  }
  return std::max(0.0, parts.top().bound_m);
}

}  // namespace contact
