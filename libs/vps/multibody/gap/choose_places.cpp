#include "vps/multibody/gap/choose_places.hpp"

#include <algorithm>
#include <limits>

#include "vps/force/direction_bins.hpp"

namespace vps {
namespace {

class PlaceChoice {
 public:
  PlaceChoice(const GapScene& scene, const NearPlaces& near, const MeasuredCorners& corners, GapPlanes* gaps,
              GapCandidates* candidates)
      : scene_(scene), near_(near), corners_(corners), slots_(gaps->slots), candidates_(*candidates) {}

  void OfferPlaces(const TouchBins& bins) {
    candidates_.clear();
    for (std::size_t b = 0; b < kNumTouchBins; ++b) {
      const TouchBin& bin = bins[b];
      begin_[b] = candidates_.size();
      if (bin.nearest == kNoPlace) continue;
      candidates_.push_back({bin.nearest, bin.nearest_depth, GapRank::kNearest});
      for (std::size_t k = 0; k < 4; ++k) {
        if (bin.outer[k] != kNoPlace) Offer({bin.outer[k], bin.depths[k]}, begin_[b], candidates_.size());
      }
    }
    begin_[kNumTouchBins] = candidates_.size();
  }
  void OfferCorners() {
    for (const MeasuredCorner& corner : corners_) {
      Offer({corner.name, -static_cast<float>(corner.gap.height), GapRank::kNearest}, begin_[kNumTouchBins],
            candidates_.size());
    }
    end_of_corners_ = candidates_.size();
  }
  // After those of this cycle, so that these renew the slots of the last ones.
  void OfferSlots() {
    for (std::size_t s = 0; s < kMaxGapPlaces; ++s) {
      if (slots_[s].cycles_left >= 0) OfferSlot(s);
    }
  }
  // Where there are more than slots, the directions choose in turns: a flank that is pressed on has many places that
  // are nearer than the nearest of the flank across, which is what the tool comes to when it is pulled back.
  void TakeInTurns() {
    std::sort(candidates_.begin(), candidates_.end());
    if (candidates_.size() <= kMaxGapPlaces) return;
    std::array<std::uint16_t, kNumDirectionBins> counts{};
    for (GapCandidate& c : candidates_) c.turn = counts[DirectionOf(c.point)]++;
    std::partial_sort(candidates_.begin(), candidates_.begin() + kMaxGapPlaces, candidates_.end());
    candidates_.resize(kMaxGapPlaces);
  }
  // Slots of those that give way are free.
  void GiveSlots() {
    std::array<bool, kMaxGapPlaces> is_taken{};
    for (const GapCandidate& c : candidates_) {
      if (c.slot >= 0) is_taken[static_cast<std::size_t>(c.slot)] = true;
    }
    std::size_t next = 0;
    for (GapCandidate& c : candidates_) {
      if (c.slot >= 0) continue;
      while (is_taken[next]) ++next;
      is_taken[next] = true;
      c.slot = static_cast<std::int8_t>(next);
      slots_[next] = {c.point, GapPlanes::kStay};
    }
    for (const GapCandidate& c : candidates_) {
      if (IsCornerOfG(c.point)) slots_[static_cast<std::size_t>(c.slot)].corner = FindCorner(corners_, c.point)->p;
    }
    for (std::size_t s = 0; s < kMaxGapPlaces; ++s) {
      if (!is_taken[s]) slots_[s] = {};
    }
  }

 private:
  // Unless it is one of the candidates from `begin` to `end`.
  void Offer(const GapCandidate& candidate, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      GapCandidate& known = candidates_[i];
      if (known.point != candidate.point) continue;
      known.rank = std::min(known.rank, candidate.rank);
      known.slot = std::max(known.slot, candidate.slot);
      return;
    }
    candidates_.push_back(candidate);
  }
  // Slots hold different places, so that it can only be one of this cycle's own.
  void OfferAgain(const GapCandidate& candidate) {
    if (IsCornerOfG(candidate.point)) {
      Offer(candidate, begin_[kNumTouchBins], end_of_corners_);
      return;
    }
    const TouchPlace& place = scene_.S.places[candidate.point];
    const std::size_t bin = TouchBinOf(place.kind, place.bin);
    Offer(candidate, begin_[bin], begin_[bin + 1]);
  }
  void OfferSlot(std::size_t s) {
    GapPlanes::Slot& slot = slots_[s];
    const float depth = DepthOf(slot.point);
    const bool is_near = depth >= -near_.margin;
    const std::size_t before = candidates_.size();
    const GapRank rank = slot.is_loaded ? GapRank::kLoaded : GapRank::kOther;
    if (is_near) OfferAgain({slot.point, depth, rank, static_cast<std::int8_t>(s)});
    const bool is_renewed = is_near && (slot.is_loaded || candidates_.size() == before);
    slot.is_loaded = false;
    slot.cycles_left = static_cast<std::int8_t>(is_renewed ? GapPlanes::kStay : slot.cycles_left - 1);
    if (candidates_.size() > before && slot.cycles_left < 0) candidates_.resize(before);
    if (!is_near) slot.cycles_left = -1;
  }
  [[nodiscard]] float DepthOf(std::uint32_t point) const {
    if (!IsCornerOfG(point)) return near_.DepthOf(point);
    const MeasuredCorner* const corner = FindCorner(corners_, point);
    return corner != nullptr ? -static_cast<float>(corner->gap.height) : -std::numeric_limits<float>::infinity();
  }
  // In which the tool is pushed there.
  [[nodiscard]] std::size_t DirectionOf(std::uint32_t point) const {
    if (!IsCornerOfG(point)) return scene_.S.places[point].bin;
    return DirectionBin(glm::vec3(glm::conjugate(scene_.X_GS.rotation) * FindCorner(corners_, point)->gap.n));
  }

  const GapScene& scene_;
  const NearPlaces& near_;
  const MeasuredCorners& corners_;
  std::array<GapPlanes::Slot, kMaxGapPlaces>& slots_;
  GapCandidates& candidates_;
  // Candidates of each bin, and the end; then come corners, then those that only have a slot.
  std::array<std::size_t, kNumTouchBins + 1> begin_;
  std::size_t end_of_corners_ = 0;
};

}  // namespace

void ChoosePlaces(const GapScene& scene, const NearPlaces& near, const TouchBins& bins, const MeasuredCorners& corners,
                  GapPlanes* gaps, GapCandidates* candidates) {
  PlaceChoice choice(scene, near, corners, gaps, candidates);
  choice.OfferPlaces(bins);
  choice.OfferCorners();
  choice.OfferSlots();
  choice.TakeInTurns();
  choice.GiveSlots();
}

}  // namespace vps
