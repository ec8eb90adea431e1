#include "vps/multibody/gap/choose_places.hpp"

#include <algorithm>
#include <limits>

#include "vps/force/direction_bins.hpp"

namespace vps {
namespace {

class PlaceChoice {
 public:
  PlaceChoice(const GapScene& scene, const NearPlaces& near, const MeasuredGaps& measured, GapPlanes* gaps,
              GapCandidates* candidates)
      : scene_(scene), near_(near), measured_(measured), slots_(gaps->slots), candidates_(*candidates) {}

  void OfferPlaces(const TouchBins& bins) {
    for (const TouchBin& bin : bins) {
      if (bin.nearest != kNoPlace) Offer({bin.nearest, bin.nearest_depth, GapRank::kNearest});
    }
    for (const TouchBin& bin : bins) {
      for (std::size_t k = 0; k < 4; ++k) {
        if (bin.outer[k] != kNoPlace) Offer({bin.outer[k], bin.depths[k]});
      }
    }
  }
  void OfferCorners() {
    for (const MeasuredGaps::One& one : measured_.all) {
      if (!IsCornerOfG(one.point)) continue;
      Offer({one.point, -static_cast<float>(one.gaps.least.height), GapRank::kNearest});
    }
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
    std::sort(candidates_.begin(), candidates_.end());
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
      if (IsCornerOfG(c.point)) slots_[static_cast<std::size_t>(c.slot)].corner = measured_.Find(c.point)->corner;
    }
    for (std::size_t s = 0; s < kMaxGapPlaces; ++s) {
      if (!is_taken[s]) slots_[s] = {};
    }
  }

 private:
  void Offer(const GapCandidate& candidate) {
    for (GapCandidate& known : candidates_) {
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
    if (is_near) Offer({slot.point, depth, rank, static_cast<std::int8_t>(s)});
    const bool is_renewed = is_near && (slot.is_loaded || candidates_.size() == before);
    slot.is_loaded = false;
    slot.cycles_left = static_cast<std::int8_t>(is_renewed ? GapPlanes::kStay : slot.cycles_left - 1);
    if (candidates_.size() > before && slot.cycles_left < 0) candidates_.resize(before);
    if (!is_near) slot.cycles_left = -1;
  }
  [[nodiscard]] float DepthOf(std::uint32_t point) const {
    if (!IsCornerOfG(point)) return near_.DepthOf(point);
    const MeasuredGaps::One* const corner = measured_.Find(point);
    return corner != nullptr ? -static_cast<float>(corner->gaps.least.height) : -std::numeric_limits<float>::infinity();
  }
  // In which the tool is pushed there.
  [[nodiscard]] std::size_t DirectionOf(std::uint32_t point) const {
    if (!IsCornerOfG(point)) return scene_.S.places[point].bin;
    return DirectionBin(glm::vec3(glm::conjugate(scene_.X_GS.rotation) * measured_.Find(point)->gaps.least.n));
  }

  const GapScene& scene_;
  const NearPlaces& near_;
  const MeasuredGaps& measured_;
  std::array<GapPlanes::Slot, kMaxGapPlaces>& slots_;
  GapCandidates& candidates_;
};

}  // namespace

void ChoosePlaces(const GapScene& scene, const NearPlaces& near, const TouchBins& bins, const MeasuredGaps& measured,
                  GapPlanes* gaps, GapCandidates* candidates) {
  PlaceChoice choice(scene, near, measured, gaps, candidates);
  choice.OfferPlaces(bins);
  choice.OfferCorners();
  choice.OfferSlots();
  choice.TakeInTurns();
  choice.GiveSlots();
}

}  // namespace vps
