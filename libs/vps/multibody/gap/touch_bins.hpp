#pragma once

#include <array>
#include <limits>

#include "core/fixed_vector.hpp"
#include "vps/force/direction_bins.hpp"
#include "vps/multibody/gap/gap.hpp"
#include "vps/multibody/gap/near_places.hpp"

namespace vps {

constexpr std::uint32_t kNoPlace = std::numeric_limits<std::uint32_t>::max();
// Faces, edges and corners of each direction: of two that are equally near none stands for the other.
constexpr std::size_t kNumTouchBins = 3 * kNumDirectionBins;
// Places of a bin that are measured exactly to find the nearest: not derived, the time for a cycle bounds them.
constexpr std::size_t kMostLikely = 4;
// Blocks of places with the deepest of a bin, in which those that can be nearest along their piece of edge are sought.
// Not derived, for the same reason; a piece's neighbours along its edge are in its block or in one next to it.
constexpr std::size_t kMostDeep = 8;

// What is farther by the field is not measured to find the nearest, voxels.
constexpr float kLikelyWithin = kMostFieldError + kUsualFieldError;

// A direction of S's surface: its nearest place, and those that are far from it on four sides without being much
// farther away. Depths are by the field, in voxels.
struct TouchBin {
  // A place, and the most depth that the field and its slope there leave to the piece of edge around it.
  struct Likely {
    std::uint32_t point = kNoPlace;
    float depth = -std::numeric_limits<float>::infinity();
  };
  // Places of a block in a bin, by the deepest of them.
  struct DeepGroup {
    float depth = -std::numeric_limits<float>::infinity();
    std::uint32_t near = 0;  // of the walk's near blocks
    std::uint16_t lanes = 0;
  };
  // A place whose gaps are known in this cycle.
  struct Measured {
    std::uint32_t point = kNoPlace;
    Gaps gaps;
  };

  std::uint32_t nearest = kNoPlace;
  float nearest_depth = -std::numeric_limits<float>::infinity();
  glm::vec3 p{0.0f};  // of the nearest, in S, metres
  std::array<std::uint32_t, 4> outer{kNoPlace, kNoPlace, kNoPlace, kNoPlace};
  std::array<float, 4> merits{};
  std::array<float, 4> depths{};
  core::FixedVector<DeepGroup, kMostDeep> deep;
  // Those that can be nearest somewhere along their piece of edge, the likeliest first.
  core::FixedVector<Likely, kMostLikely> likely;
  core::FixedVector<Measured, kMostLikely> measured;

  void Clear() {
    nearest = kNoPlace;
    nearest_depth = -std::numeric_limits<float>::infinity();
    outer.fill(kNoPlace);
    merits.fill(0.0f);
    deep.clear();
    likely.clear();
    measured.clear();
  }
};

using TouchBins = std::array<TouchBin, kNumTouchBins>;

// Of a TouchPlace or a TouchGroup.
inline std::size_t TouchBinOf(const auto& one) {
  return static_cast<std::size_t>(one.kind) * kNumDirectionBins + one.bin;
}

// Sorts the near places into the bins.
void FillBins(const GapScene& scene, const NearPlaces& near, TouchBins* bins);

}  // namespace vps
