#include "vps/multibody/gap/choose_places.hpp"

#include <algorithm>
#include <limits>

#include "vps/force/direction_bins.hpp"

namespace vps {
namespace {

class PlaceChoice {
 public:
  PlaceChoice(const GapScene& scene, const NearPlaces& near, GapPlanes* gaps, GapScratch* now)
      : scene_(scene), near_(near), corners_(now->corners), slots_(gaps->slots), candidates_(now->candidates) {
    candidates_.clear();
    begin_.fill(GapCandidates::kCapacity);
  }

  void OfferPlaces(const TouchBins& bins) {
    for (std::size_t b = 0; b < kNumTouchBins; ++b) {
      const TouchBin& bin = bins[b];
      begin_[b] = candidates_.size();
      if (bin.nearest == kNoPlace) continue;
      Offer({bin.nearest, bin.nearest_depth, GapRank::kNearest}, b);
      for (std::size_t k = 0; k < 4; ++k) {
        if (bin.outer[k] != kNoPlace) Offer({bin.outer[k], bin.depths[k]}, b);
      }
    }
  }
  void OfferCorners() {
    begin_[kNumTouchBins] = candidates_.size();
    for (const MeasuredCorner& corner : corners_) {
      Offer({corner.name, -static_cast<float>(corner.gap.height), GapRank::kNearest}, kNumTouchBins);
    }
    begin_[kNumTouchBins + 1] = candidates_.size();
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
      if (c.slot < 0) {
        while (is_taken[next]) ++next;
        is_taken[next] = true;
        c.slot = static_cast<std::int8_t>(next);
        slots_[next] = {c.point, GapPlanes::kStay};
      }
      if (IsCornerOfG(c.point)) slots_[static_cast<std::size_t>(c.slot)].corner = FindCorner(corners_, c.point)->p;
    }
    for (std::size_t s = 0; s < kMaxGapPlaces; ++s) {
      if (!is_taken[s]) slots_[s] = {};
    }
  }

 private:
  // Corners of G come after the bins of places.
  [[nodiscard]] std::size_t BinOf(std::uint32_t point) const {
    return IsCornerOfG(point) ? kNumTouchBins : TouchBinOf(scene_.S.places[point]);
  }
  // Unless it is one of this cycle's own, of its bin. Those that only have a slot are different places.
  void Offer(const GapCandidate& candidate, std::size_t bin) {
    const std::size_t end = std::min(begin_[bin + 1], candidates_.size());
    for (std::size_t i = begin_[bin]; i < end; ++i) {
      GapCandidate& known = candidates_[i];
      if (known.point != candidate.point) continue;
      known.rank = std::min(known.rank, candidate.rank);
      known.slot = std::max(known.slot, candidate.slot);
      return;
    }
    candidates_.push_back(candidate);
  }
  void OfferSlot(std::size_t s) {
    GapPlanes::Slot& slot = slots_[s];
    const float depth = DepthOf(slot.point);
    const bool is_near = depth >= -near_.margin;
    const std::size_t before = candidates_.size();
    const GapRank rank = slot.is_loaded ? GapRank::kLoaded : GapRank::kOther;
    if (is_near) Offer({slot.point, depth, rank, static_cast<std::int8_t>(s)}, BinOf(slot.point));
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
  // This cycle's candidates of each bin, corners of G, the end; then come those that only have a slot.
  std::array<std::size_t, kNumTouchBins + 2> begin_;
};

}  // namespace

void ChoosePlaces(const GapScene& scene, const NearPlaces& near, GapPlanes* gaps, GapScratch* now) {
  PlaceChoice choice(scene, near, gaps, now);
  choice.OfferPlaces(now->bins);
  choice.OfferCorners();
  choice.OfferSlots();
  choice.TakeInTurns();
  choice.GiveSlots();
}

}  // namespace vps
