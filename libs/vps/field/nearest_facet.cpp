#include "vps/field/nearest_facet.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vps/field/four_lanes.hpp"
#include "vps/mesh/nearest_on_triangle.hpp"

namespace vps {
namespace {

// Of triangles that share the nearest edge or corner the one whose plane is farthest from the point has its side:
// squared distances get so much of their part within the plane on top.
constexpr double kBeside = 1e-6;

// Squared distances of boxes from a point, `pad` less along each axis: lanes k to k + 3.
F4 SquaredDistances(const std::array<const float*, 3>& low, const std::array<const float*, 3>& high, const glm::vec3& p,
                    float pad, std::size_t k) {
  F4 sum{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const F4 beyond = Max4(Max4(Load4(low[a] + k) - p[axis], p[axis] - Load4(high[a] + k)) - pad, F4{});
    sum += beyond * beyond;
  }
  return sum;
}

// Of the least of a multiple of four values.
std::size_t LeastOf(const float* values, std::size_t count) {
  F4 least = Load4(values);
  for (std::size_t k = 4; k < count; k += 4) least = -Max4(-least, -Load4(values + k));
  const float value = std::min(std::min(least[0], least[1]), std::min(least[2], least[3]));
  std::size_t k = 0;
  while (values[k] != value) ++k;
  return k;
}

// Against the rounding of floats [voxels]: of a grid of thousands of voxels, and within 64.
constexpr float kPadInGrid = 1e-3f;
constexpr float kPadInBall = 1e-4f;

// Goes through the blocks whose boxes come as near to p as the root of `squared_reach`, which may fall on the way, the
// nearest first: meet(block, middle).
template <class Meet>
struct Descent {
  const Facets& facets;
  glm::dvec3 p;
  const double& squared_reach;
  const Meet& meet;

  void MeetLevel(std::uint32_t level, std::uint32_t index) {
    const std::uint32_t at = facets.level_begin[level] + index;
    const FacetBoxes& boxes = facets.boxes[at];
    alignas(16) std::array<float, kFacetLanes> bounds;
    for (std::size_t k = 0; k < kFacetLanes; k += 4) {
      const F4 squares = SquaredDistances({boxes.low[0], boxes.low[1], boxes.low[2]},
                                          {boxes.high[0], boxes.high[1], boxes.high[2]}, glm::vec3(p), kPadInGrid, k);
      Store4(squares, &bounds[k]);
    }
    while (true) {
      const auto best = static_cast<std::uint32_t>(LeastOf(bounds.data(), kFacetLanes));
      if (static_cast<double>(bounds[best]) >= squared_reach) return;
      bounds[best] = std::numeric_limits<float>::infinity();
      const std::uint32_t child = index * kFacetLanes + best;
      if (level > 0) {
        MeetLevel(level - 1, child);
      } else {
        const FacetSpheres& spheres = facets.spheres[at];
        meet(facets.blocks[child], glm::dvec3(spheres.x[best], spheres.y[best], spheres.z[best]));
      }
    }
  }
};
// Clang 14, which builds the fuzzers, cannot deduce it of an aggregate.
template <class Meet>
Descent(const Facets&, const glm::dvec3&, const double&, const Meet&) -> Descent<Meet>;

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
    if (h * h >= key * nn) return;
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
  const auto meet = [&](const FacetBlock& block, const glm::dvec3& middle) {
    const glm::dvec3 from = p - middle;
    std::array<glm::dvec3, kFacetLanes> corners;
    for (std::uint32_t k = 0; k < kFacetLanes; ++k) {
      corners[k] = static_cast<double>(kFacetStep) * glm::dvec3(block.x[k], block.y[k], block.z[k]) - from;
    }
    for (std::uint32_t k = 0; k < kFacetLanes; ++k) {
      const std::uint16_t of = block.corners[k];
      if (k > 0 && of == block.corners[k - 1]) break;  // the last one is repeated
      search.Meet(corners[of & 15U], corners[of >> 4 & 15U], corners[of >> 8 & 15U], (of & kDoubtful) != 0);
    }
  };
  Descent{facets, p, search.key, meet}.MeetLevel(facets.num_levels - 1, 0);
  return search.Result();
}

void FacetsAround::Add(const Facet& facet) {
  if (count_ == kMost) {
    is_full_ = true;
    return;
  }
  const auto& [a, b, c] = facet.corners;
  const glm::vec3 low(glm::min(a, glm::min(b, c)) - middle_);
  const glm::vec3 high(glm::max(a, glm::max(b, c)) - middle_);
  for (int axis = 0; axis < 3; ++axis) {
    low_[static_cast<std::size_t>(axis)][count_] = low[axis];
    high_[static_cast<std::size_t>(axis)][count_] = high[axis];
  }
  near_[count_++] = facet;
}

void FacetsAround::Gather(const Facets& facets, const glm::dvec3& p, double radius) noexcept {
  all_ = &facets;
  middle_ = p;
  count_ = 0;
  is_full_ = false;
  if (facets.num_levels == 0) return;
  const double squared = radius * radius;
  const auto meet = [&](const FacetBlock& block, const glm::dvec3& middle) {
    // Of each corner on which sides of a box around the ball it is: a triangle with all corners beyond one is not near.
    const glm::dvec3 from = (p - middle) / static_cast<double>(kFacetStep);
    const double reach = radius / static_cast<double>(kFacetStep);
    const auto bound = [](double steps) {
      return static_cast<std::int32_t>(std::clamp(steps, -1.0 - kMostFacetSteps, 0.0 + kMostFacetSteps));
    };
    const glm::dvec3 low = glm::floor(from - reach);
    const glm::dvec3 high = glm::ceil(from + reach);
    std::array<std::uint16_t, kFacetLanes> beyond;
    for (std::uint32_t k = 0; k < kFacetLanes; ++k) {
      beyond[k] =
          static_cast<std::uint16_t>((block.x[k] < bound(low.x) ? 1 : 0) | (block.x[k] > bound(high.x) ? 2 : 0));
    }
    for (std::uint32_t k = 0; k < kFacetLanes; ++k) {
      beyond[k] = static_cast<std::uint16_t>(beyond[k] | (block.y[k] < bound(low.y) ? 4 : 0) |
                                             (block.y[k] > bound(high.y) ? 8 : 0));
    }
    for (std::uint32_t k = 0; k < kFacetLanes; ++k) {
      beyond[k] = static_cast<std::uint16_t>(beyond[k] | (block.z[k] < bound(low.z) ? 16 : 0) |
                                             (block.z[k] > bound(high.z) ? 32 : 0));
    }
    for (std::uint32_t k = 0; k < kFacetLanes; ++k) {
      const std::uint16_t of = block.corners[k];
      if (k > 0 && of == block.corners[k - 1]) break;  // the last one is repeated
      const std::array<std::uint32_t, 3> corners{of & 15U, of >> 4 & 15U, of >> 8 & 15U};
      if ((beyond[corners[0]] & beyond[corners[1]] & beyond[corners[2]]) != 0) continue;
      Facet facet;
      facet.is_doubtful = (of & kDoubtful) != 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t j = corners[i];
        facet.corners[i] = middle + static_cast<double>(kFacetStep) * glm::dvec3(block.x[j], block.y[j], block.z[j]);
      }
      Add(facet);
    }
  };
  Descent{facets, p, squared, meet}.MeetLevel(facets.num_levels - 1, 0);
  if (is_full_) count_ = 0;
  FillUp();
}

void FacetsAround::FillUp() {
  for (std::size_t k = count_; k % 4 != 0; ++k) {
    for (std::size_t axis = 0; axis < 3; ++axis) low_[axis][k] = high_[axis][k] = Facets::kFarAway;
  }
}

void FacetsAround::LeaveOut(const NearestFacet& face) noexcept {
  constexpr double kSamePlane = 2.0 * kSamePlace;
  std::size_t left = 0;
  for (std::size_t k = 0; k < count_; ++k) {
    const auto is_in_plane = [&](const glm::dvec3& corner) {
      return std::abs(glm::dot(corner - face.place, face.normal)) < kSamePlane;
    };
    const auto& [a, b, c] = near_[k].corners;
    if (is_in_plane(a) && is_in_plane(b) && is_in_plane(c)) continue;
    if (left < k) near_[left] = near_[k];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low_[axis][left] = low_[axis][k];
      high_[axis][left] = high_[axis][k];
    }
    ++left;
  }
  count_ = left;
  FillUp();
}

// The box that is nearest first: what it holds is mostly the nearest, and then few others can be nearer.
NearestFacet FacetsAround::FindNearest(const glm::dvec3& p, double reach) const noexcept {
  if (is_full_) return FindNearestFacet(*all_, p, reach);
  if (count_ == 0) return {};
  const glm::vec3 at(p - middle_);
  Lane bounds;
  for (std::size_t k = 0; k < count_; k += 4) {
    const F4 squares = SquaredDistances({low_[0].data(), low_[1].data(), low_[2].data()},
                                        {high_[0].data(), high_[1].data(), high_[2].data()}, at, kPadInBall, k);
    Store4(squares, &bounds[k]);
  }
  Search search{p, reach * reach, {}};
  const auto meet = [&](std::size_t k) {
    const Facet& facet = near_[k];
    search.Meet(facet.corners[0] - p, facet.corners[1] - p, facet.corners[2] - p, facet.is_doubtful);
  };
  const std::size_t first = LeastOf(bounds.data(), (count_ + 3) / 4 * 4);
  if (static_cast<double>(bounds[first]) >= search.key) return {};
  meet(first);
  for (std::size_t k = 0; k < count_; ++k) {
    if (k != first && static_cast<double>(bounds[k]) < search.key) meet(k);
  }
  return search.Result();
}

}  // namespace vps
