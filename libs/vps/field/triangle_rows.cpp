#include "vps/field/triangle_rows.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>

#include "vps/mesh/wide_clones.hpp"

namespace vps {
namespace {

using Lanes = float __attribute__((vector_size(kRow * sizeof(float))));
using Numbers = std::uint32_t __attribute__((vector_size(kRow * sizeof(std::uint32_t))));

[[gnu::always_inline]] inline void Load(const float* from, Lanes* to) {
  __builtin_memcpy(to, from, sizeof(Lanes));
}

using Ints = std::int32_t __attribute__((vector_size(kRow * sizeof(std::int32_t))));

// Triangles nearer than kClose [voxels] to a cell's centre get no tangent bound: rounding may turn its direction. Of
// farther ones it is lowered by kTangentRounding of the squared distance, at least by that. Not derived: ten times the
// errors of RowTriangle.
constexpr float kClose = 0.25f;
constexpr float kTangentRounding = 0.01f;
constexpr float kBoundRounding = 2e-3f;  // of distances to boxes and planes: twice the error of RowTriangle

// Bit i: lane i of the comparison holds.
[[gnu::always_inline]] inline std::uint32_t BitsOf(const Ints& comparison) {
  constexpr Ints kLaneBits = {1, 2, 4, 8, 16, 32, 64, 128};
  const Ints lanes = comparison & kLaneBits;
  std::uint32_t bits = 0;
  for (int i = 0; i < kRow; ++i) bits |= static_cast<std::uint32_t>(lanes[i]);
  return bits;
}

// From the nearest points of the edges.
struct EdgeDistances {
  Lanes squared;
  Lanes way_x, way_y, way_z;  // to the point
  Lanes prism;                // least distance into the prism over the face
};
[[gnu::always_inline]] inline void FindEdgeDistances(const RowTriangle& t, const Lanes& x, const Lanes& y,
                                                     const Lanes& z, EdgeDistances* out) {
  Lanes least = Lanes{} + std::numeric_limits<float>::max();
  Lanes prism = least;
  out->way_x = out->way_y = out->way_z = Lanes{};
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
    const auto is_nearer = here < least;
    out->way_x = is_nearer ? rx : out->way_x;
    out->way_y = is_nearer ? ry : out->way_y;
    out->way_z = is_nearer ? rz : out->way_z;
    least = is_nearer ? here : least;
    prism = inside < prism ? inside : prism;
  }
  out->squared = least;
  out->prism = prism;
}

// The nearest point is on the face when the point lies over it, else on one of the edges.
struct TriangleDistances {
  EdgeDistances edges;
  Lanes height;  // over the plane
  Ints is_over_face;
  Lanes squared;
};
[[gnu::always_inline]] inline void FindDistances(const RowTriangle& t, const Lanes& x, const Lanes& y, const Lanes& z,
                                                 TriangleDistances* out) {
  FindEdgeDistances(t, x, y, z, &out->edges);
  out->height = ((x * t.normal.x + y * t.normal.y) + z * t.normal.z) - t.offset;
  out->is_over_face = out->edges.prism >= t.prism_margin;
  out->squared = out->is_over_face ? out->height * out->height : out->edges.squared;
}

// Bit y: some sample of the row (y, z) may lie within reach of the triangle's box and of its plane.
[[gnu::always_inline]] inline std::uint32_t FindReachedRows(const RowTriangle& t, float z, float reach) {
  constexpr Lanes kY = {0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f};
  const float dx = std::max(std::max(t.lower.x - 7.0f, -t.upper.x), 0.0f);
  const float dz = std::max(std::max(t.lower.z - z, z - t.upper.z), 0.0f);
  const Lanes below = t.lower.y - kY;
  const Lanes above = kY - t.upper.y;
  Lanes dy = below > above ? below : above;
  dy = dy > 0.0f ? dy : Lanes{};
  const Lanes middle = t.normal.y * kY + (t.normal.x * 3.5f + t.normal.z * z - t.offset);
  const Lanes height = middle < 0.0f ? -middle : middle;
  return BitsOf(((dx * dx + dz * dz) + dy * dy <= reach * reach) & (height <= std::abs(t.normal.x) * 3.5f + reach));
}

[[gnu::always_inline]] inline void SampleRow(const RowTriangle& t, float y, float z, Lanes* squared) {
  constexpr Lanes kX = {0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f};
  TriangleDistances found;
  FindDistances(t, kX, Lanes{} + y, Lanes{} + z, &found);
  *squared = found.squared;
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

TriangleBounds::TriangleBounds(std::span<const RowTriangle> triangles) : groups_((triangles.size() + kRow - 1) / kRow) {
  for (std::size_t n = 0; n < kRow * groups_.size(); ++n) {
    Group& group = groups_[n / kRow];
    const std::size_t i = n % kRow;
    const bool is_there = n < triangles.size();
    for (int axis = 0; axis < 3; ++axis) {
      group.lower[axis][i] = is_there ? triangles[n].lower[axis] : std::numeric_limits<float>::max();
      group.upper[axis][i] = is_there ? triangles[n].upper[axis] : -std::numeric_limits<float>::max();
      group.normal[axis][i] = is_there ? triangles[n].normal[axis] : 0.0f;
    }
    group.offset[i] = is_there ? triangles[n].offset : 0.0f;
  }
}

VPS_WIDE_CLONES std::uint32_t TriangleBounds::FindReaching(std::size_t group, float first_x, float last_x, float y,
                                                           float z, float reach) const {
  const Group& g = groups_[group];
  const float first[3] = {first_x, y, z};
  const float last[3] = {last_x, y, z};
  Lanes squared{};
  for (int axis = 0; axis < 3; ++axis) {
    Lanes lower, upper;
    Load(g.lower[axis], &lower);
    Load(g.upper[axis], &upper);
    const Lanes below = lower - last[axis];
    const Lanes above = first[axis] - upper;
    Lanes out = below > above ? below : above;
    out = out > 0.0f ? out : Lanes{};
    squared += out * out;
  }
  Lanes nx, ny, nz, offset;
  Load(g.normal[0], &nx);
  Load(g.normal[1], &ny);
  Load(g.normal[2], &nz);
  Load(g.offset, &offset);
  const Lanes height = ((nx * (0.5f * (first_x + last_x)) + ny * y) + nz * z) - offset;
  const Lanes size = height < 0.0f ? -height : height;
  const Lanes slope = nx < 0.0f ? -nx : nx;
  return BitsOf((squared <= reach * reach) & (size <= slope * (0.5f * (last_x - first_x)) + reach));
}

VPS_WIDE_CLONES void FindNear(std::span<const RowTriangle> triangles, const TriangleBounds& bounds,
                              std::span<const std::uint32_t> numbers, int y, int z, const float* reach,
                              std::array<std::vector<NearTriangle>, kRow>* near) {
  constexpr Lanes kX = {0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f};
  Lanes reaches;
  Load(reach, &reaches);
  const std::uint32_t wanted = BitsOf(reaches >= 0.0f);
  const auto first_x = static_cast<float>(std::countr_zero(wanted));
  const auto last_x = static_cast<float>(31 - std::countl_zero(wanted));
  float largest = 0.0f;
  for (int x = 0; x < kRow; ++x) largest = std::max(largest, reach[x]);
  const Lanes limits = reaches >= 0.0f ? reaches * reaches : Lanes{} - 1.0f;
  const Lanes fy = Lanes{} + static_cast<float>(y);
  const Lanes fz = Lanes{} + static_cast<float>(z);
  for (auto& list : *near) list.clear();
  for (std::size_t group = 0; group < bounds.num_groups(); ++group) {
    std::uint32_t left = bounds.FindReaching(group, first_x, last_x, fy[0], fz[0], largest + kBoundRounding);
    for (; left != 0; left &= left - 1) {
      const std::size_t n = group * kRow + static_cast<std::size_t>(std::countr_zero(left));
      const RowTriangle& t = triangles[n];
      TriangleDistances here;
      FindDistances(t, kX, fy, fz, &here);
      std::uint32_t within = BitsOf(here.squared <= limits);
      if (within == 0) continue;
      const Lanes squared = here.squared;
      const Lanes way_x = here.is_over_face ? here.height * t.normal.x : here.edges.way_x;
      const Lanes way_y = here.is_over_face ? here.height * t.normal.y : here.edges.way_y;
      const Lanes way_z = here.is_over_face ? here.height * t.normal.z : here.edges.way_z;
      for (; within != 0; within &= within - 1) {
        const int x = std::countr_zero(within);
        NearTriangle found{numbers[n], &t, squared[x]};
        if (squared[x] > kClose * kClose) {
          found.tangent = squared[x] - kTangentRounding * std::max(1.0f, squared[x]);
          found.way = glm::vec3(way_x[x], way_y[x], way_z[x]);
        }
        (*near)[static_cast<std::size_t>(x)].push_back(found);
      }
    }
  }
}

namespace {

// Nearest triangles so far of eight points.
struct NearestRow {
  Lanes x, y, z;  // of the points, from the centre
  Lanes squared = Lanes{} + std::numeric_limits<float>::max();
  Lanes height{};
  Numbers triangle{};
  Ints is_over_face{};
};

[[gnu::always_inline]] inline void KeepNearerOf(const RowTriangle& t, std::uint32_t n, const glm::vec3& centre,
                                                NearestRow* row) {
  TriangleDistances here;
  FindDistances(t, row->x + centre.x, row->y + centre.y, row->z + centre.z, &here);
  const Ints is_kept =
      (here.squared < row->squared) | ((here.squared == row->squared) & (Ints)(Numbers{} + n < row->triangle));
  row->squared = is_kept ? here.squared : row->squared;
  row->height = is_kept ? here.height : row->height;
  row->triangle = is_kept ? Numbers{} + n : row->triangle;
  row->is_over_face = is_kept ? here.is_over_face : row->is_over_face;
}

// Whether the triangle may be the nearest of a point, lane by lane. The distance is convex, so it is at least its
// tangent at the centre: with w from the triangle's nearest point to the centre,  d(centre + offset) >= |w| + offset .
// w / |w|.
[[gnu::always_inline]] inline void FindPossiblyNearer(const NearTriangle& t, const NearestRow& row, Ints* doubt) {
  Lanes tangent = ((row.x * t.way.x + row.y * t.way.y) + row.z * t.way.z) + t.tangent;  // times |w|
  tangent = tangent > 0.0f ? tangent : Lanes{};
  *doubt = tangent * tangent <= row.squared * t.squared;
}

}  // namespace

VPS_WIDE_CLONES void FindNearest(std::span<const NearTriangle> near, const glm::vec3& centre, const PointRow* offsets,
                                 NearestOfPoints* out) {
  NearestRow rows[kNearRows];
  std::uint32_t first = 0;  // a good one to begin with: most others are then left out
  for (std::uint32_t n = 1; n < near.size(); ++n) first = near[n].squared < near[first].squared ? n : first;
  for (int i = 0; i < kNearRows; ++i) {
    Load(offsets[i].x, &rows[i].x);
    Load(offsets[i].y, &rows[i].y);
    Load(offsets[i].z, &rows[i].z);
    KeepNearerOf(*near[first].rows, first, centre, &rows[i]);
  }
  for (std::uint32_t n = 0; n < near.size(); ++n) {
    if (n == first) continue;
    Ints doubt[kNearRows];
    for (int i = 0; i < kNearRows; ++i) FindPossiblyNearer(near[n], rows[i], &doubt[i]);
    if (BitsOf(doubt[0] | doubt[1] | doubt[2]) == 0) continue;
    for (int i = 0; i < kNearRows; ++i) {
      if (BitsOf(doubt[i]) != 0) KeepNearerOf(*near[n].rows, n, centre, &rows[i]);
    }
  }
  for (int i = 0; i < kNearRows; ++i) {
    __builtin_memcpy(out->height + i * kRow, &rows[i].height, sizeof rows[i].height);
    __builtin_memcpy(out->triangle + i * kRow, &rows[i].triangle, sizeof rows[i].triangle);
    for (int k = 0; k < kRow; ++k) out->is_over_face[i * kRow + k] = rows[i].is_over_face[k] != 0;
  }
}

NearestSamples::NearestSamples(float reach, std::uint32_t none) {
  std::fill(std::begin(squared), std::end(squared), reach * reach);
  std::fill(std::begin(triangle), std::end(triangle), none);
}

VPS_WIDE_CLONES void AddTriangle(const RowTriangle& triangle, std::uint32_t number, float reach,
                                 NearestSamples* samples) {
  const int first_z = std::max(0, static_cast<int>(std::ceil(triangle.lower.z - reach)));
  const int last_z = std::min(7, static_cast<int>(std::floor(triangle.upper.z + reach)));
  for (int z = first_z; z <= last_z; ++z) {
    std::uint32_t rows = FindReachedRows(triangle, static_cast<float>(z), reach + kBoundRounding);
    for (; rows != 0; rows &= rows - 1) {
      const int y = std::countr_zero(rows);
      const int at = (z * 8 + y) * 8;
      Lanes here, least;
      Numbers nearest;
      SampleRow(triangle, static_cast<float>(y), static_cast<float>(z), &here);
      Load(samples->squared + at, &least);
      __builtin_memcpy(&nearest, samples->triangle + at, sizeof nearest);
      const auto is_nearer = here < least;
      least = is_nearer ? here : least;
      nearest = is_nearer ? Numbers{} + number : nearest;
      __builtin_memcpy(samples->squared + at, &least, sizeof least);
      __builtin_memcpy(samples->triangle + at, &nearest, sizeof nearest);
    }
  }
}

}  // namespace vps
