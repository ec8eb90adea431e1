#pragma once

#include "vps/multibody/gap/corner_gap.hpp"
#include "vps/multibody/gap/gap_planes.hpp"
#include "vps/multibody/gap/touch_bins.hpp"

namespace vps {

enum class GapRank : std::uint8_t { kLoaded, kNearest, kOther };

// A place of S, or a corner of G by its name, that may get a plane in this cycle.
struct GapCandidate {
  std::uint32_t point = 0;
  float depth = 0.0f;  // voxels
  GapRank rank = GapRank::kOther;
  std::int8_t slot = -1;
  std::uint16_t turn = 0;  // of its direction

  bool operator<(const GapCandidate& other) const {
    if (turn != other.turn) return turn < other.turn;
    if (rank != other.rank) return rank < other.rank;
    return depth != other.depth ? depth > other.depth : point < other.point;
  }
};

using GapCandidates = core::FixedVector<GapCandidate, 5 * kNumTouchBins + kMostCorners + kMaxGapPlaces>;

// Memory of a query. Large, and little of it is used by one, so it is not made anew for each.
struct GapScratch {
  TouchBins bins;
  CornersBelow below;
  MeasuredCorners corners;
  GapCandidates candidates;
  FacetsAround around;
};

// Candidates: of this cycle's places and corners and those that have a slot, at most as many as there are slots, each
// with one. Slots that nobody has any more are free.
void ChoosePlaces(const GapScene& scene, const NearPlaces& near, GapPlanes* gaps, GapScratch* now);

}  // namespace vps
