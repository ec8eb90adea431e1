#include <algorithm>
#include <numeric>

#include "vps/walk/field_walk.hpp"

namespace vps {

// Blocks tested whatever the budget. Not derived: with 64 the deepest point was found to a tenth of a voxel
// (FieldWalk.ErrorFallsWithTheBudgetAndTheDeepestPointStays).
constexpr std::uint32_t kAlways = 64;

// The blocks that are deepest by estimate, at least kAlways: they hold the deepest point unless the field is rougher
// than a block. Proven bounds instead would need nine tenths of a pressed peg's blocks. Of blocks equally deep, the
// first.
void FieldWalkScratch::PickDeepest(std::uint32_t most_blocks) {
  most_blocks = std::max(most_blocks, kAlways);
  if (num_blocks_ <= most_blocks) return;
  FindBlocks(estimates_.data());
  most_blocks = std::min(most_blocks, num_blocks_);  // now that all are tested there can be fewer
  const auto picked = picked_.begin() + static_cast<std::ptrdiff_t>(most_blocks);
  const auto end = picked_.begin() + static_cast<std::ptrdiff_t>(num_blocks_);
  std::iota(picked_.begin(), end, 0U);
  std::nth_element(picked_.begin(), picked, end, [&](std::uint32_t a, std::uint32_t b) {
    return estimates_[a] != estimates_[b] ? estimates_[a] < estimates_[b] : a < b;
  });
  std::sort(picked_.begin(), picked);
  for (std::uint32_t i = 0; i < most_blocks; ++i) blocks_[i] = blocks_[picked_[i]];
  result_.is_cut_short = true;
  num_blocks_ = most_blocks;
}

}  // namespace vps
