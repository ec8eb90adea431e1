#include "vps/walk/find_room.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace vps {
namespace {

constexpr std::int32_t kReplaced = std::numeric_limits<std::int32_t>::max();

using Keys = std::array<std::int32_t, kBlock>;

// By halves, for the vector registers.
std::int32_t Least(Keys keys) {
  for (std::size_t k = 0; k < 8; ++k) keys[k] = std::min(keys[k], keys[k + 8]);
  for (std::size_t k = 0; k < 4; ++k) keys[k] = std::min(keys[k], keys[k + 4]);
  return std::min(std::min(keys[0], keys[1]), std::min(keys[2], keys[3]));
}

}  // namespace

std::uint32_t FindRoom(const WalkInput& in, const WalkKernels& kernels, double* room) {
  static_assert(kMostLooks < kBlock);
  std::array<Keys, kBlock> blocks;
  std::array<std::uint32_t, kBlock> levels;
  std::array<std::uint32_t, kBlock> numbers;
  Keys least;  // of each block
  least.fill(kReplaced);
  std::uint32_t num_blocks = 0;
  const auto look = [&](std::uint32_t level, std::uint32_t number) {
    levels[num_blocks] = level;
    numbers[num_blocks] = number;
    kernels.bound(in, in.level_begin[level] + number, blocks[num_blocks].data());
    least[num_blocks] = Least(blocks[num_blocks]);
    ++num_blocks;
  };
  look(in.num_levels - 1, 0);
  for (;;) {
    const std::int32_t key = Least(least);
    const auto from = static_cast<std::size_t>(std::find(least.begin(), least.end(), key) - least.begin());
    if (num_blocks > kMostLooks || levels[from] == 0) {
      *room = static_cast<double>(key >> 4) / kRoomSteps;
      return num_blocks * kBlock;
    }
    const std::uint32_t lane = static_cast<std::uint32_t>(key) % kBlock;
    blocks[from][lane] = kReplaced;
    least[from] = Least(blocks[from]);
    look(levels[from] - 1, numbers[from] * kBlock + lane);
  }
}

}  // namespace vps
