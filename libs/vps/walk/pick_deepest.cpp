#include <algorithm>
#include <span>

#include "vps/walk/field_walk.hpp"

namespace vps {
namespace {

constexpr std::uint32_t kLevels = 256;  // of a bucket sort
// Blocks tested whatever the budget. Not derived: with 64 the deepest point was found to a tenth of a voxel
// (FieldWalk.ErrorFallsWithTheBudgetAndTheDeepestPointStays).
constexpr std::uint32_t kAlways = 64;

// Ranks of blocks by their least distance, in so many equal steps.
class Ranks {
 public:
  Ranks(std::span<const float> least, float margin) : low_(*std::min_element(least.begin(), least.end())) {
    per_voxel_ = static_cast<float>(kLevels - 1) / std::max(margin - low_, 1e-6f);
    for (const float d : least) ++count_[Of(d)];
  }
  [[nodiscard]] std::uint32_t Of(float distance) const {
    return static_cast<std::uint32_t>(
        std::clamp((distance - low_) * per_voxel_, 0.0f, static_cast<float>(kLevels - 1)));
  }
  // All blocks of ranks below `rank` and the first `more` of it.
  struct Share {
    std::uint32_t rank, more;
  };
  [[nodiscard]] Share First(std::uint32_t blocks) const {
    std::uint32_t rank = 0;
    for (; rank < kLevels && count_[rank] <= blocks; ++rank) blocks -= count_[rank];
    return {rank, blocks};
  }
  // `from` and `to` may be the same.
  std::uint32_t Pick(Share share, std::span<const float> least, const std::uint32_t* from, std::uint32_t* to) const {
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < least.size(); ++i) {
      const std::uint32_t rank = Of(least[i]);
      if (rank > share.rank || (rank == share.rank && share.more == 0)) continue;
      share.more -= rank == share.rank ? 1 : 0;
      to[count++] = from[i];
    }
    return count;
  }

 private:
  float low_, per_voxel_;
  std::uint32_t count_[kLevels] = {};
};

}  // namespace

// The blocks that are deepest by estimate, at least kAlways: they hold the deepest point unless the field is rougher
// than a block. Proven bounds instead would need nine tenths of a pressed peg's blocks.
void FieldWalkScratch::PickDeepest(std::uint32_t most_blocks) {
  most_blocks = std::max(most_blocks, kAlways);
  if (num_blocks_ <= most_blocks) return;
  FindBlocks(estimates_.data());
  const std::span<const float> least(estimates_.data(), num_blocks_);
  const Ranks ranks(least, input_.margin);
  result_.is_cut_short = true;
  num_blocks_ = ranks.Pick(ranks.First(most_blocks), least, blocks_, blocks_);
}

}  // namespace vps
