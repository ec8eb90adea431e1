#pragma once

#include <cstdint>
#include <vector>

namespace visual_node {

// Which physics states a wall keeps: of ticks that are multiples of kTicksPerKept, among the newest kMostKept of them,
// and of the named one (KeptScenes). It can lack any of them, because a busy machine's receiver takes the newest state
// and skips those before.
struct KeptTicks {
  // Chosen: not every tick is kept, because a scene is copied for each; and a quarter of a second is longer than a
  // message between two walls takes on a busy machine.
  static constexpr std::uint64_t kTicksPerKept = 4;
  static constexpr std::size_t kMostKept = 64;

  std::uint64_t newest = 0;  // 0: none
  std::uint64_t kept = 0;    // bit i: newest - i kTicksPerKept is kept

  [[nodiscard]] bool Has(std::uint64_t tick) const {
    if (tick == 0 || tick > newest || (newest - tick) % kTicksPerKept != 0) return false;
    const std::uint64_t periods = (newest - tick) / kTicksPerKept;
    return periods < kMostKept && ((kept >> periods) & 1U) != 0;
  }
  void Add(std::uint64_t tick) {
    if (tick > newest) {
      const std::uint64_t periods = (tick - newest) / kTicksPerKept;
      kept = newest == 0 || periods >= kMostKept ? 0 : kept << periods;
      newest = tick;
    }
    const std::uint64_t periods = (newest - tick) / kTicksPerKept;
    if (periods < kMostKept) kept |= std::uint64_t{1} << periods;
  }
};

// Which state the first wall names: the newest that all walls have. Where they have none in common, because each has
// received others, the one named `last`, which all of them still have. A wall that is so far behind that its states
// have stopped does not hold up the rest.
inline std::uint64_t NewestCommonTick(const KeptTicks& own, const std::vector<KeptTicks>& others, std::uint64_t last) {
  constexpr std::uint64_t kMostBehind = 500;  // chosen: as long as a picture may stand still
  const auto is_behind = [&](std::uint64_t tick) { return tick + kMostBehind < own.newest; };
  for (std::size_t i = 0; i < KeptTicks::kMostKept && own.newest > i * KeptTicks::kTicksPerKept; ++i) {
    const std::uint64_t tick = own.newest - i * KeptTicks::kTicksPerKept;
    bool is_common = own.Has(tick);
    for (const KeptTicks& other : others) is_common = is_common && (other.Has(tick) || is_behind(other.newest));
    if (is_common) return tick;
  }
  const bool is_last_of_use = last != 0 && last <= own.newest && !is_behind(last);
  return is_last_of_use ? last : own.newest;
}

}  // namespace visual_node
