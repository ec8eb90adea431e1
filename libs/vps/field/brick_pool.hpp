#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "vps/field/distance_field.hpp"

namespace vps {

// Bricks of words one after the other, equal ones once: along a flat face that is parallel to the grid most are. The
// first, at word 0, leaves every cell to the coarse grid.
class BrickPool {
 public:
  using Brick = std::span<const std::uint32_t, DistanceField::kBrickWords>;

  BrickPool() : words_(DistanceField::kBrickWords, kCoarseWord) {}

  // Reserves address space for so many bricks, so that adding does not move them.
  void Reserve(std::size_t num_bricks) { words_.reserve((num_bricks + 1) * DistanceField::kBrickWords); }

  static std::uint64_t HashOf(Brick brick);
  // First word of an equal brick already stored, or of the copy made. `hash`: HashOf(brick).
  std::uint32_t Add(Brick brick, std::uint64_t hash);
  // Stores a brick known to equal none; first word of the copy.
  std::uint32_t AddDistinct(Brick brick);

  [[nodiscard]] const std::uint32_t* brick(std::uint32_t first_word) const { return &words_[first_word]; }
  // Ends the pool.
  [[nodiscard]] std::vector<std::uint32_t> TakeWords();

 private:
  std::vector<std::uint32_t> words_;
  std::unordered_map<std::uint64_t, std::uint32_t> first_of_hash_;
};

}  // namespace vps
