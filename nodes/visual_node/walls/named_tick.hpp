#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "nodes/visual_node/walls/barrier.hpp"
#include "nodes/visual_node/walls/kept_ticks.hpp"

namespace visual_node {

// Which state the first wall names for the next frame: the newest that all walls have. Where they have none in common,
// because each has received others or has not been heard, the last one again, which all of them still have. Walls
// that are dead, or get no states, hold up the picture for a moment, once.
class NamedTick {
 public:
  // What another wall has said that it keeps.
  struct Claim {
    KeptTicks kept;
    std::int64_t heard_ns = 0;  // 0: never
  };

  std::uint64_t Next(const KeptTicks& own, const std::vector<Claim>& claims, std::int64_t now_ns) {
    std::uint64_t tick = NewestCommonTick(own, KeptBy(claims, 0));
    if (tick != 0) {
      lacking_since_ns_ = 0;
    } else {
      if (lacking_since_ns_ == 0) lacking_since_ns_ = now_ns;
      const bool is_last_kept = last_ != 0 && last_ <= own.newest;
      const bool waits = is_last_kept && now_ns - lacking_since_ns_ < Barrier::kPatience_ns;
      tick = waits ? last_ : NewestCommonTick(own, KeptBy(claims, now_ns - Barrier::kSilence_ns));
    }
    last_ = tick != 0 ? tick : own.newest;
    return last_;
  }

 private:
  // Of walls that have states, and were heard after that time.
  static std::vector<KeptTicks> KeptBy(const std::vector<Claim>& claims, std::int64_t after_ns) {
    std::vector<KeptTicks> kept;
    for (const Claim& claim : claims) {
      if (claim.kept.newest != 0 && claim.heard_ns > std::max<std::int64_t>(after_ns, 0)) kept.push_back(claim.kept);
    }
    return kept;
  }

  std::uint64_t last_ = 0;
  std::int64_t lacking_since_ns_ = 0;  // 0: the last frame's state was one that all had
};

}  // namespace visual_node
