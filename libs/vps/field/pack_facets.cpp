#include "vps/field/pack_facets.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

namespace vps {
namespace {

// In steps of kFacetStep, so that equal corners are equal.
using Corner = glm::ivec3;
struct Facet {
  std::array<Corner, 3> corners;
  bool is_doubtful = false;
  const Corner& operator[](std::size_t k) const { return corners[k]; }
};

// Steps. A block's corners lie within kMostFacetSteps of its middle; those of a triangle no larger than this along each
// axis do, wherever in it the middle lies.
constexpr int kLongest = kMostFacetSteps / 10 * 9;
// Triangles aimed at for a block: sixteen connected ones often have more than sixteen corners. Not derived.
constexpr std::size_t kWanted = 14;
constexpr double kSteps = 1.0 / static_cast<double>(kFacetStep);

Corner Rounded(const glm::dvec3& p) {
  return Corner(glm::round(p * kSteps));
}

void AddFacet(const std::array<glm::dvec3, 3>& t, bool is_doubtful, std::vector<Facet>* facets) {
  const Facet facet{{Rounded(t[0]), Rounded(t[1]), Rounded(t[2])}, is_doubtful};
  const glm::ivec3 extent =
      glm::max(facet[0], glm::max(facet[1], facet[2])) - glm::min(facet[0], glm::min(facet[1], facet[2]));
  if (std::max({extent.x, extent.y, extent.z}) <= kLongest) {
    const glm::dvec3 area = glm::cross(glm::dvec3(facet[1] - facet[0]), glm::dvec3(facet[2] - facet[0]));
    // What rounding has turned over is no wider than a step.
    if (glm::dot(area, glm::cross(t[1] - t[0], t[2] - t[0])) > 0.0) facets->push_back(facet);
    return;
  }
  int k = 0;
  const auto side = [&](int i) {
    return glm::distance(t[static_cast<std::size_t>(i)], t[static_cast<std::size_t>((i + 1) % 3)]);
  };
  for (int i = 1; i < 3; ++i) {
    if (side(i) > side(k)) k = i;
  }
  const glm::dvec3& a = t[static_cast<std::size_t>(k)];
  const glm::dvec3& b = t[static_cast<std::size_t>((k + 1) % 3)];
  const glm::dvec3& c = t[static_cast<std::size_t>((k + 2) % 3)];
  const glm::dvec3 middle = 0.5 * (a + b);
  AddFacet({a, middle, c}, is_doubtful, facets);
  AddFacet({middle, b, c}, is_doubtful, facets);
}

// The block of these triangles, if they have few enough corners and lie close enough together.
struct Packed {
  FacetBlock block{};
  Corner middle{0};
  double radius = 0.0;  // steps
};
std::optional<Packed> Pack(std::span<const Facet> facets) {
  if (facets.size() > kFacetLanes) return std::nullopt;
  std::vector<Corner> corners;
  Packed out;
  for (std::size_t i = 0; i < kFacetLanes; ++i) {
    const Facet& facet = facets[std::min(i, facets.size() - 1)];
    if (facet.is_doubtful) out.block.corners[i] = kDoubtful;
    for (int k = 0; k < 3; ++k) {
      auto at = std::find(corners.begin(), corners.end(), facet[static_cast<std::size_t>(k)]);
      if (at == corners.end()) at = corners.insert(corners.end(), facet[static_cast<std::size_t>(k)]);
      out.block.corners[i] = static_cast<std::uint16_t>(out.block.corners[i] | (at - corners.begin()) << 4 * k);
    }
    if (corners.size() > kFacetLanes) return std::nullopt;
  }
  Corner lower = corners[0];
  Corner upper = corners[0];
  for (const Corner& c : corners) {
    lower = glm::min(lower, c);
    upper = glm::max(upper, c);
  }
  out.middle = lower + (upper - lower) / 2;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::ivec3 from = corners[i] - out.middle;
    if (std::max({std::abs(from.x), std::abs(from.y), std::abs(from.z)}) > kMostFacetSteps) return std::nullopt;
    out.block.x[i] = from.x;
    out.block.y[i] = from.y;
    out.block.z[i] = from.z;
    out.radius = std::max(out.radius, glm::length(glm::dvec3(from)));
  }
  return out;
}

// Halves along the longest extent of the middles, at whole multiples of what a block takes, until parts can be packed.
void Divide(std::span<Facet> facets, std::vector<Packed>* blocks) {
  if (facets.size() <= kFacetLanes) {
    if (const auto packed = Pack(facets)) {
      blocks->push_back(*packed);
      return;
    }
  }
  glm::ivec3 lower(2'000'000'000);
  glm::ivec3 upper(-2'000'000'000);
  const auto sum = [](const Facet& f) { return f[0] / 3 + f[1] / 3 + f[2] / 3; };
  for (const Facet& f : facets) {
    lower = glm::min(lower, sum(f));
    upper = glm::max(upper, sum(f));
  }
  const glm::dvec3 extent = glm::dvec3(upper) - glm::dvec3(lower);
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : (extent.y >= extent.z ? 1 : 2);
  const std::size_t parts = (facets.size() + kWanted - 1) / kWanted;
  const std::size_t first =
      facets.size() <= kFacetLanes ? facets.size() / 2 : std::max<std::size_t>(parts / 2, 1) * kWanted;
  std::nth_element(facets.begin(), facets.begin() + static_cast<std::ptrdiff_t>(first), facets.end(),
                   [&](const Facet& a, const Facet& b) {
                     const int at_a = sum(a)[axis];
                     const int at_b = sum(b)[axis];
                     if (at_a != at_b) return at_a < at_b;
                     for (std::size_t k = 0; k < 3; ++k) {
                       for (int i = 0; i < 3; ++i) {
                         if (a[k][i] != b[k][i]) return a[k][i] < b[k][i];
                       }
                     }
                     return false;
                   });
  Divide(facets.first(first), blocks);
  Divide(facets.subspan(first), blocks);
}

FacetSpheres NoSpheres() {
  FacetSpheres none{};
  std::fill(std::begin(none.x), std::end(none.x), Facets::kFarAway);
  std::fill(std::begin(none.y), std::end(none.y), Facets::kFarAway);
  std::fill(std::begin(none.z), std::end(none.z), Facets::kFarAway);
  return none;
}

void PutSphere(std::size_t i, const glm::vec3& c, float r, std::span<FacetSpheres> level) {
  FacetSpheres& block = level[i / kFacetLanes];
  block.x[i % kFacetLanes] = c.x;
  block.y[i % kFacetLanes] = c.y;
  block.z[i % kFacetLanes] = c.z;
  block.r[i % kFacetLanes] = r;
}

// Around the used spheres of a block.
glm::vec4 Around(const FacetSpheres& block) {
  glm::vec3 lower(1e30f);
  glm::vec3 upper(-1e30f);
  const auto is_used = [&](std::size_t k) { return block.x[k] != Facets::kFarAway; };
  for (std::size_t k = 0; k < kFacetLanes; ++k) {
    if (!is_used(k)) continue;
    const glm::vec3 c(block.x[k], block.y[k], block.z[k]);
    lower = glm::min(lower, c - block.r[k]);
    upper = glm::max(upper, c + block.r[k]);
  }
  const glm::vec3 middle = 0.5f * (lower + upper);
  float r = 0.0f;
  for (std::size_t k = 0; k < kFacetLanes; ++k) {
    if (is_used(k)) r = std::max(r, glm::length(glm::vec3(block.x[k], block.y[k], block.z[k]) - middle) + block.r[k]);
  }
  return {middle, r};
}

float HighestUsed(const FacetBoxes& boxes, std::size_t axis) {
  float highest = -Facets::kFarAway;
  for (std::size_t k = 0; k < kFacetLanes; ++k) {
    if (boxes.low[axis][k] < Facets::kFarAway) highest = std::max(highest, boxes.high[axis][k]);
  }
  return highest;
}

// Covers the rounding of a radius computed in floats, some of 2^-24 = 6e-8 each, with a margin that is not derived.
constexpr float kPad = 1.0f + 1e-5f;

}  // namespace

Facets PackFacets(const TriangleField& triangles, std::size_t most_bytes) {
  Facets out;
  if (triangles.num_triangles() * sizeof(FacetBlock) / kFacetLanes > most_bytes) return out;
  std::vector<Facet> facets;
  for (std::uint32_t t = 0; t < triangles.num_triangles(); ++t)
    AddFacet(triangles.corners(t), !triangles.side_is_sign(t), &facets);
  if (facets.empty()) return out;
  std::vector<Packed> packed;
  Divide(facets, &packed);
  std::size_t count = packed.size();
  while (true) {
    const std::size_t begin = out.spheres.size();
    out.level_begin[out.num_levels++] = static_cast<std::uint32_t>(begin);
    out.spheres.resize(begin + (count + kFacetLanes - 1) / kFacetLanes, NoSpheres());
    const std::span<FacetSpheres> level(out.spheres.data() + begin, out.spheres.size() - begin);
    for (std::size_t i = 0; i < count; ++i) {
      if (out.num_levels == 1) {
        PutSphere(i, glm::vec3(packed[i].middle) * kFacetStep, static_cast<float>(packed[i].radius / kSteps) * kPad,
                  level);
      } else {
        const glm::vec4 sphere = Around(out.spheres[out.level_begin[out.num_levels - 2] + i]);
        PutSphere(i, glm::vec3(sphere), sphere.w * kPad, level);
      }
    }
    count = level.size();
    if (count == 1) break;
    if (out.num_levels == Facets::kMaxLevels) return {};
  }
  out.blocks.reserve(packed.size());
  for (const Packed& p : packed) out.blocks.push_back(p.block);
  if (out.num_bytes() > most_bytes) return {};
  MakeBoxes(&out);
  return out;
}

void MakeBoxes(Facets* facets) {
  facets->boxes.assign(facets->spheres.size(), {});
  std::size_t count = facets->blocks.size();
  for (std::uint32_t level = 0; level < facets->num_levels; ++level) {
    const std::size_t begin = facets->level_begin[level];
    const std::size_t num_parents = (count + kFacetLanes - 1) / kFacetLanes;
    for (std::size_t i = 0; i < num_parents * kFacetLanes; ++i) {
      FacetBoxes& boxes = facets->boxes[begin + i / kFacetLanes];
      const std::size_t k = i % kFacetLanes;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        boxes.low[axis][k] = boxes.high[axis][k] = Facets::kFarAway;
        if (i >= count) continue;
        if (level > 0) {
          const FacetBoxes& below = facets->boxes[facets->level_begin[level - 1] + i];
          boxes.low[axis][k] = *std::min_element(below.low[axis], below.low[axis] + kFacetLanes);
          boxes.high[axis][k] = HighestUsed(below, axis);
        } else {
          const FacetBlock& block = facets->blocks[i];
          const FacetSpheres& spheres = facets->spheres[begin + i / kFacetLanes];
          const float middle = axis == 0 ? spheres.x[k] : (axis == 1 ? spheres.y[k] : spheres.z[k]);
          const auto* const steps = axis == 0 ? block.x : (axis == 1 ? block.y : block.z);
          const auto [least, most] = std::minmax_element(steps, steps + kFacetLanes);
          boxes.low[axis][k] = middle + kFacetStep * static_cast<float>(*least);
          boxes.high[axis][k] = middle + kFacetStep * static_cast<float>(*most);
        }
      }
    }
    count = num_parents;
  }
}

}  // namespace vps
