#pragma once

#include "vps/multibody/gap/corner_gap.hpp"
#include "vps/multibody/gap/touch_bins.hpp"

namespace vps {

// What was measured exactly in this cycle.
struct MeasuredGaps {
  // A place of S, or a corner of G: `point` is its name then.
  struct One {
    std::uint32_t point = kNoPlace;
    Gaps gaps;
    glm::dvec3 corner{0.0};
  };
  core::FixedVector<One, kMostLikely * kNumTouchBins + kMostCorners> all;

  [[nodiscard]] const One* Find(std::uint32_t point) const {
    for (const One& one : all) {
      if (one.point == point) return &one;
    }
    return nullptr;
  }
};

}  // namespace vps
