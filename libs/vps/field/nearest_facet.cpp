#include "vps/field/nearest_facet.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vps {
namespace {

// Of triangles that share the nearest edge or corner the one whose plane is farthest from the point has its side:
// squared distances get so much of their part within the plane on top.
constexpr double kBeside = 1e-6;

struct Search {
  const Facets& facets;
  glm::dvec3 p;
  double key;  // squared
  NearestFacet nearest;
  bool is_doubtful = false;

  // A sphere block's spheres that may hold something nearer, as bits.
  [[nodiscard]] unsigned Near(const FacetSpheres& s, std::array<float, kFacetLanes>* bounds) const {
    const float x = static_cast<float>(p.x);
    const float y = static_cast<float>(p.y);
    const float z = static_cast<float>(p.z);
    const auto reach = static_cast<float>(std::sqrt(key)) + 1e-3f;
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
      const double most = static_cast<double>(spheres.r[best]) + std::sqrt(key) + 1e-3;
      if (static_cast<double>(bounds[best]) >= most * most) continue;
      const std::uint32_t child = block * kFacetLanes + best;
      if (level > 0) {
        MeetLevel(level - 1, child);
      } else {
        MeetBlock(facets.blocks[child], {spheres.x[best], spheres.y[best], spheres.z[best]});
      }
    }
  }

  void MeetBlock(const FacetBlock& block, const glm::dvec3& middle) {
    const glm::dvec3 from = p - middle;
    std::array<glm::dvec3, kFacetLanes> corners;
    for (std::uint32_t k = 0; k < kFacetLanes; ++k) {
      corners[k] = static_cast<double>(kFacetStep) * glm::dvec3(block.x[k], block.y[k], block.z[k]) - from;
    }
    for (std::uint32_t k = 0; k < kFacetLanes; ++k) {
      const std::uint16_t of = block.corners[k];
      if (k > 0 && of == block.corners[k - 1]) break;  // the last one is repeated
      MeetTriangle(corners[of & 15U], corners[of >> 4 & 15U], corners[of >> 8 & 15U], (of & kDoubtful) != 0);
    }
  }

  // Corners relative to p (Ericson 2005, 5.1.5).
  void MeetTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, bool has_doubt) {
    const glm::dvec3 ab = b - a;
    const glm::dvec3 ac = c - a;
    const glm::dvec3 n = glm::cross(ab, ac);
    const double nn = glm::dot(n, n);
    const double h = glm::dot(n, a);
    if (h * h >= key * nn) return;
    const double d1 = -glm::dot(ab, a);
    const double d2 = -glm::dot(ac, a);
    const double d3 = -glm::dot(ab, b);
    const double d4 = -glm::dot(ac, b);
    const double d5 = -glm::dot(ab, c);
    const double d6 = -glm::dot(ac, c);
    const double va = d3 * d6 - d5 * d4;
    const double vb = d5 * d2 - d1 * d6;
    const double vc = d1 * d4 - d3 * d2;
    glm::dvec3 q;
    bool is_on_face = false;
    if (d1 <= 0.0 && d2 <= 0.0) {
      q = a;
    } else if (d3 >= 0.0 && d4 <= d3) {
      q = b;
    } else if (d6 >= 0.0 && d5 <= d6) {
      q = c;
    } else if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
      q = a + d1 / (d1 - d3) * ab;
    } else if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
      q = a + d2 / (d2 - d6) * ac;
    } else if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
      q = b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
    } else {
      q = h / nn * n;
      is_on_face = true;
    }
    const double squared = glm::dot(q, q);
    const double beside = is_on_face ? 0.0 : std::max(squared - h * h / nn, 0.0);
    if (squared + kBeside * beside >= key) return;
    key = squared + kBeside * beside;
    is_doubtful = has_doubt;
    nearest.is_found = true;
    nearest.is_on_face = is_on_face;
    nearest.place = p + q;
    nearest.normal = n / std::sqrt(nn);
    nearest.corners = {p + a, p + b, p + c};
    nearest.height = std::copysign(std::sqrt(squared), -h);
  }
};

}  // namespace

NearestFacet FindNearestFacet(const Facets& facets, const glm::dvec3& p, double reach) noexcept {
  if (facets.num_levels == 0) return {};
  Search search{facets, p, reach * reach, {}};
  search.MeetLevel(facets.num_levels - 1, 0);
  if (search.is_doubtful) search.nearest.is_found = false;
  return search.nearest;
}

}  // namespace vps
