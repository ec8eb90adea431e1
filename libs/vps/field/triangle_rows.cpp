#include "vps/field/triangle_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vps/field/wide_clones.hpp"

namespace vps {
namespace {

using Lanes = float __attribute__((vector_size(kRow * sizeof(float))));
using Numbers = std::uint32_t __attribute__((vector_size(kRow * sizeof(std::uint32_t))));

[[gnu::always_inline]] inline void Load(const float* from, Lanes* to) {
  __builtin_memcpy(to, from, sizeof(Lanes));
}

// The nearest point is on the face when the point lies over it, else on one of the edges.
[[gnu::always_inline]] inline void RowDistances(const RowTriangle& t, const Lanes& x, const Lanes& y, const Lanes& z,
                                                Lanes* squared) {
  Lanes least = Lanes{} + std::numeric_limits<float>::max();
  Lanes prism = least;
  for (const RowTriangle::Edge& e : t.edges) {
    const Lanes wx = x - e.start.x;
    const Lanes wy = y - e.start.y;
    const Lanes wz = z - e.start.z;
    Lanes s = ((wx * e.along.x + wy * e.along.y) + wz * e.along.z) * e.inverse_squared_length;
    s = s > 0.0f ? s : Lanes{};
    s = s < 1.0f ? s : Lanes{} + 1.0f;
    const Lanes rx = wx - s * e.along.x;
    const Lanes ry = wy - s * e.along.y;
    const Lanes rz = wz - s * e.along.z;
    const Lanes here = (rx * rx + ry * ry) + rz * rz;
    const Lanes inside = (wx * e.inward.x + wy * e.inward.y) + wz * e.inward.z;
    least = here < least ? here : least;
    prism = inside < prism ? inside : prism;
  }
  const Lanes height = ((x * t.normal.x + y * t.normal.y) + z * t.normal.z) - t.offset;
  *squared = prism >= t.prism_margin ? height * height : least;
}

// Whether some sample of the row may lie within reach of the triangle's box and of its plane.
[[gnu::always_inline]] inline bool MayReach(const RowTriangle& t, float y, float z, float reach) {
  const float dy = std::max(std::max(t.lower.y - y, y - t.upper.y), 0.0f);
  const float dz = std::max(std::max(t.lower.z - z, z - t.upper.z), 0.0f);
  if (dy * dy + dz * dz > reach * reach) return false;
  const float middle = ((t.normal.x * 3.5f + t.normal.y * y) + t.normal.z * z) - t.offset;
  return std::abs(middle) <= std::abs(t.normal.x) * 3.5f + reach;
}

[[gnu::always_inline]] inline void SampleRow(const RowTriangle& t, float y, float z, Lanes* squared) {
  constexpr Lanes kX = {0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f};
  RowDistances(t, kX, Lanes{} + y, Lanes{} + z, squared);
}

// Where a triangle's distances are less than the least so far, they and its number are kept.
[[gnu::always_inline]] inline void KeepNearer(const Lanes& here, std::uint32_t number, Lanes* least, Numbers* nearest) {
  const auto is_nearer = here < *least;
  *least = is_nearer ? here : *least;
  *nearest = is_nearer ? Numbers{} + number : *nearest;
}

}  // namespace

RowTriangle::RowTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 corners[3] = {a, b, c};
  glm::dvec3 n = glm::cross(b - a, c - a);
  const double length = glm::length(n);
  n = length > 0.0 ? n / length : glm::dvec3(0.0);
  for (int k = 0; k < 3; ++k) {
    const glm::dvec3 along = corners[(k + 1) % 3] - corners[k];
    const double squared = glm::dot(along, along);
    edges[k].start = glm::vec3(corners[k]);
    edges[k].along = glm::vec3(along);
    edges[k].inverse_squared_length = squared > 0.0 ? static_cast<float>(1.0 / squared) : 0.0f;
    edges[k].inward = glm::vec3(squared > 0.0 ? glm::cross(n, along) / std::sqrt(squared) : n);
  }
  lower = glm::min(edges[0].start, glm::min(edges[1].start, edges[2].start));
  upper = glm::max(edges[0].start, glm::max(edges[1].start, edges[2].start));
  normal = glm::vec3(n);
  offset = static_cast<float>(glm::dot(n, a));
  prism_margin = length > 0.0 ? 0.0f : std::numeric_limits<float>::infinity();
}

VPS_WIDE_CLONES void FindNearest(std::span<const NearTriangle> near, const PointRow& points, float* squared,
                                 std::uint32_t* nearest) {
  Lanes x, y, z;
  Load(points.x, &x);
  Load(points.y, &y);
  Load(points.z, &z);
  Lanes best = Lanes{} + std::numeric_limits<float>::max();
  Numbers numbers{};
  for (std::uint32_t n = 0; n < near.size(); ++n) {
    Lanes here;
    RowDistances(*near[n].rows, x, y, z, &here);
    KeepNearer(here, n, &best, &numbers);
  }
  __builtin_memcpy(squared, &best, sizeof best);
  __builtin_memcpy(nearest, &numbers, sizeof numbers);
}

VPS_WIDE_CLONES bool SampleDistances(const RowTriangle& triangle, int y, int z, float reach, float* squared) {
  const auto fy = static_cast<float>(y);
  const auto fz = static_cast<float>(z);
  if (triangle.lower.x > 7.0f + reach || triangle.upper.x < -reach) return false;
  if (!MayReach(triangle, fy, fz, reach)) return false;
  Lanes out;
  SampleRow(triangle, fy, fz, &out);
  __builtin_memcpy(squared, &out, sizeof out);
  return true;
}

VPS_WIDE_CLONES void AddTriangle(const RowTriangle& triangle, std::uint32_t number, float reach,
                                 NearestSamples* samples) {
  const glm::vec3& lower = triangle.lower;
  const glm::vec3& upper = triangle.upper;
  if (lower.x > 7.0f + reach || upper.x < -reach) return;
  const int first_z = std::max(0, static_cast<int>(std::ceil(lower.z - reach)));
  const int last_z = std::min(7, static_cast<int>(std::floor(upper.z + reach)));
  const int first_y = std::max(0, static_cast<int>(std::ceil(lower.y - reach)));
  const int last_y = std::min(7, static_cast<int>(std::floor(upper.y + reach)));
  for (int z = first_z; z <= last_z; ++z) {
    for (int y = first_y; y <= last_y; ++y) {
      if (!MayReach(triangle, static_cast<float>(y), static_cast<float>(z), reach)) continue;
      const int at = (z * 8 + y) * 8;
      Lanes here, least;
      Numbers nearest;
      SampleRow(triangle, static_cast<float>(y), static_cast<float>(z), &here);
      Load(samples->squared + at, &least);
      __builtin_memcpy(&nearest, samples->triangle + at, sizeof nearest);
      KeepNearer(here, number, &least, &nearest);
      __builtin_memcpy(samples->squared + at, &least, sizeof least);
      __builtin_memcpy(samples->triangle + at, &nearest, sizeof nearest);
    }
  }
}

}  // namespace vps
