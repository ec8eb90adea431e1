#include "vps/walk/bound_free_distance.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

namespace vps {
namespace {

using I4 = std::int32_t __attribute__((vector_size(16)));

// Sixteen numbers that stay in registers: what is written to memory one by one and read back at once as a vector waits.
struct Keys {
  I4 of[4];

  void Set(std::uint32_t lane, std::int32_t key) {
    I4 lanes = {0, 1, 2, 3};
    for (I4& four : of) {
      four = lanes == static_cast<std::int32_t>(lane) ? I4{} + key : four;
      lanes += 4;
    }
  }
  [[nodiscard]] std::int32_t least() const {
    const auto min = [](const I4& a, const I4& b) { return a < b ? a : b; };
    I4 v = min(min(of[0], of[1]), min(of[2], of[3]));
    v = min(v, __builtin_shufflevector(v, v, 2, 3, 0, 1));
    return std::min(v[0], v[1]);
  }
};
constexpr std::int32_t kReplaced = std::numeric_limits<std::int32_t>::max() / kBlock;

}  // namespace

std::uint32_t BoundFreeDistance(const WalkInput& in, const WalkKernels& kernels, double* free_distance) {
  static_assert(kMostSphereBlocks + 2 < kBlock);
  std::array<Keys, kBlock> blocks;
  std::array<std::uint32_t, kBlock> levels;
  std::array<std::uint32_t, kBlock> numbers;
  Keys least;  // of each block, times sixteen, and the block's number
  for (I4& four : least.of) four = I4{} + std::numeric_limits<std::int32_t>::max();
  std::uint32_t num_blocks = 0;
  const auto renew = [&](std::uint32_t i) {
    least.Set(i, blocks[i].least() * static_cast<std::int32_t>(kBlock) + static_cast<std::int32_t>(i));
  };
  const auto look = [&](std::uint32_t level, std::uint32_t number) {
    levels[num_blocks] = level;
    numbers[num_blocks] = number;
    std::int32_t keys[kBlock];
    kernels.bound(in, in.level_begin[level] + number, keys);
    std::memcpy(&blocks[num_blocks], keys, sizeof keys);
    renew(num_blocks++);
  };
  look(in.num_levels - 1, 0);
  for (;;) {
    // Two at once: neither has to wait for the other.
    struct {
      std::uint32_t level, number;
    } next[2];
    std::uint32_t num_next = 0;
    for (; num_next < 2; ++num_next) {
      const std::int32_t key = least.least();
      const std::uint32_t from = static_cast<std::uint32_t>(key) % kBlock;
      if (num_next == 0) *free_distance = static_cast<double>(key >> 8) / kFreeDistanceSteps;
      if (num_blocks > kMostSphereBlocks || levels[from] == 0) break;
      const std::uint32_t lane = static_cast<std::uint32_t>(key >> 4) % kBlock;
      blocks[from].Set(lane, kReplaced);
      renew(from);
      next[num_next] = {levels[from] - 1, numbers[from] * kBlock + lane};
    }
    if (num_next == 0) return num_blocks * kBlock;
    for (std::uint32_t i = 0; i < num_next; ++i) look(next[i].level, next[i].number);
  }
}

}  // namespace vps
