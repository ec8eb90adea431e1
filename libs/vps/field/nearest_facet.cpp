#include "vps/field/nearest_facet.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vps/mesh/nearest_on_triangle.hpp"

namespace vps {
namespace {

// Of triangles that share the nearest edge or corner the one whose plane is farthest from the point has its side:
// squared distances get so much of their part within the plane on top.
constexpr double kBeside = 1e-6;

// Goes through the triangles of blocks that come as near to p as the root of `squared_reach`, which may fall on the
// way: take(a, b, c, is_doubtful), corners relative to p.
template <class Take>
struct Descent {
  const Facets& facets;
  glm::dvec3 p;
  const double& squared_reach;
  const Take& take;

  // A sphere block's spheres that may hold something nearer, as bits.
  [[nodiscard]] unsigned Near(const FacetSpheres& s, std::array<float, kFacetLanes>* bounds) const {
    const float x = static_cast<float>(p.x);
    const float y = static_cast<float>(p.y);
    const float z = static_cast<float>(p.z);
    const auto reach = static_cast<float>(std::sqrt(squared_reach)) + 1e-3f;
    std::array<float, kFacetLanes> over;
    for (std::uint32_t k = 0; k < kFacetLanes; ++k) {
      const float dx = s.x[k] - x;
      const float dy = s.y[k] - y;
      const float dz = s.z[k] - z;
      const float most = s.r[k] + reach;
      (*bounds)[k] = dx * dx + dy * dy + dz * dz;
      over[k] = (*bounds)[k] - most * most;
    }
    unsigned bits = 0;
    for (std::uint32_t k = 0; k < kFacetLanes; ++k) bits |= (over[k] < 0.0f ? 1U : 0U) << k;
    return bits;
  }

  void MeetLevel(std::uint32_t level, std::uint32_t block) {
    const FacetSpheres& spheres = facets.spheres[facets.level_begin[level] + block];
    std::array<float, kFacetLanes> bounds;
    for (unsigned bits = Near(spheres, &bounds); bits != 0;) {
      // The nearest first, so that the others are passed over sooner.
      unsigned best = static_cast<unsigned>(__builtin_ctz(bits));
      for (unsigned rest = bits & (bits - 1); rest != 0; rest &= rest - 1) {
        const auto k = static_cast<unsigned>(__builtin_ctz(rest));
        if (bounds[k] < bounds[best]) best = k;
      }
      bits &= ~(1U << best);
      const double most = static_cast<double>(spheres.r[best]) + std::sqrt(squared_reach) + 1e-3;
      if (static_cast<double>(bounds[best]) >= most * most) continue;
      const std::uint32_t child = block * kFacetLanes + best;
      if (level > 0) {
        MeetLevel(level - 1, child);
      } else {
        MeetBlock(facets.blocks[child], {spheres.x[best], spheres.y[best], spheres.z[best]});
      }
    }
  }

  // The spheres of long thin triangles are wide, the boxes of those along an axis are not.
  static bool IsNear(const FacetBlock& block, const glm::dvec3& from, double squared) {
    const auto beyond = [](const std::int16_t* at, double to) {
      std::int16_t low = at[0];
      std::int16_t high = at[0];
      for (std::uint32_t k = 1; k < kFacetLanes; ++k) {
        low = std::min(low, at[k]);
        high = std::max(high, at[k]);
      }
      constexpr auto kStep = static_cast<double>(kFacetStep);
      return std::max({kStep * static_cast<double>(low) - to, to - kStep * static_cast<double>(high), 0.0});
    };
    const glm::dvec3 way(beyond(block.x, from.x), beyond(block.y, from.y), beyond(block.z, from.z));
    return glm::dot(way, way) < squared;
  }

  void MeetBlock(const FacetBlock& block, const glm::dvec3& middle) {
    const glm::dvec3 from = p - middle;
    if (!IsNear(block, from, squared_reach)) return;
    std::array<glm::dvec3, kFacetLanes> corners;
    for (std::uint32_t k = 0; k < kFacetLanes; ++k) {
      corners[k] = static_cast<double>(kFacetStep) * glm::dvec3(block.x[k], block.y[k], block.z[k]) - from;
    }
    for (std::uint32_t k = 0; k < kFacetLanes; ++k) {
      const std::uint16_t of = block.corners[k];
      if (k > 0 && of == block.corners[k - 1]) break;  // the last one is repeated
      take(corners[of & 15U], corners[of >> 4 & 15U], corners[of >> 8 & 15U], (of & kDoubtful) != 0);
    }
  }
};
// Clang 14 deduces none for an aggregate by itself.
template <typename Take>
Descent(const Facets&, glm::dvec3, const double&, const Take&) -> Descent<Take>;

struct Search {
  glm::dvec3 p;
  double key;  // squared
  NearestFacet nearest;
  bool is_doubtful = false;

  // Corners relative to p.
  void Meet(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, bool has_doubt) {
    const glm::dvec3 n = glm::cross(b - a, c - a);
    const double nn = glm::dot(n, n);
    const double h = glm::dot(n, a);
    if (h * h < key * nn) MeetNear(a, b, c, n, h, nn, has_doubt);
  }
  void MeetNear(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& n, double h, double nn,
                bool has_doubt) {
    const OnTriangle closest = NearestOnTriangle(a, b, c, n);
    const double squared = glm::dot(closest.place, closest.place);
    const double beside = closest.is_on_face ? 0.0 : std::max(squared - h * h / nn, 0.0);
    if (squared + kBeside * beside >= key) return;
    key = squared + kBeside * beside;
    is_doubtful = has_doubt;
    nearest.is_found = true;
    nearest.is_on_face = closest.is_on_face;
    nearest.place = p + closest.place;
    nearest.normal = n / std::sqrt(nn);
    nearest.corners = {p + a, p + b, p + c};
    nearest.height = std::copysign(std::sqrt(squared), -h);
  }
  [[nodiscard]] NearestFacet Result() {
    if (is_doubtful) nearest.is_found = false;
    return nearest;
  }
};

}  // namespace

NearestFacet FindNearestFacet(const Facets& facets, const glm::dvec3& p, double reach) noexcept {
  if (facets.num_levels == 0) return {};
  Search search{p, reach * reach, {}};
  const auto take = [&](const auto& a, const auto& b, const auto& c, bool is_doubtful) {
    search.Meet(a, b, c, is_doubtful);
  };
  Descent{facets, p, search.key, take}.MeetLevel(facets.num_levels - 1, 0);
  return search.Result();
}

void FacetsAround::Gather(const Facets& facets, const glm::dvec3& p, double radius) noexcept {
  all_ = &facets;
  near_.clear();
  is_full_ = false;
  if (facets.num_levels == 0) return;
  const double squared = radius * radius;
  const auto take = [&](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, bool is_doubtful) {
    const glm::dvec3 n = glm::cross(b - a, c - a);
    const double nn = glm::dot(n, n);
    const double h = glm::dot(n, a);
    if (is_full_ || h * h >= squared * nn) return;
    const glm::dvec3 q = NearestOnTriangle(a, b, c, n).place;
    if (glm::dot(q, q) >= squared) return;
    const glm::dvec3 normal = n / std::sqrt(nn);
    is_full_ = !near_.push_back({{p + a, p + b, p + c}, normal, glm::dot(normal, p + a), is_doubtful});
  };
  Descent{facets, p, squared, take}.MeetLevel(facets.num_levels - 1, 0);
  if (is_full_) near_.clear();
}

NearestFacet FacetsAround::FindNearest(const glm::dvec3& p, double reach) const noexcept {
  if (is_full_) return FindNearestFacet(*all_, p, reach);
  Search search{p, reach * reach, {}};
  for (const Facet& facet : near_) {
    const double h = facet.height - glm::dot(facet.normal, p);
    if (h * h >= search.key) continue;
    search.MeetNear(facet.corners[0] - p, facet.corners[1] - p, facet.corners[2] - p, facet.normal, h, 1.0,
                    facet.is_doubtful);
  }
  return search.Result();
}

}  // namespace vps
