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

// The newest tick that `own` and all the others have; 0: none.
inline std::uint64_t NewestCommonTick(const KeptTicks& own, const std::vector<KeptTicks>& others) {
  for (std::size_t i = 0; i < KeptTicks::kMostKept && own.newest > i * KeptTicks::kTicksPerKept; ++i) {
    const std::uint64_t tick = own.newest - i * KeptTicks::kTicksPerKept;
    bool is_common = own.Has(tick);
    for (const KeptTicks& other : others) is_common = is_common && other.Has(tick);
    if (is_common) return tick;
  }
  return 0;
}

}  // namespace visual_node
