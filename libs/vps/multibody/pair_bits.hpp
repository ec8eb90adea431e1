#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vps {

// A set of pairs that is walked in ascending order: one bit a pair, so that thousands of pairs cost a few loads.
class PairBits {
 public:
  explicit PairBits(std::size_t num_pairs = 0) : words_((num_pairs + 63) / 64, 0) {}
  void Set(std::size_t pair) { words_[pair / 64] |= std::uint64_t{1} << (pair % 64); }
  void Clear(std::size_t pair) { words_[pair / 64] &= ~(std::uint64_t{1} << (pair % 64)); }
  void ClearAll() { std::fill(words_.begin(), words_.end(), 0); }
  void Add(const PairBits& other) {
    for (std::size_t w = 0; w < words_.size(); ++w) words_[w] |= other.words_[w];
  }
  template <typename Visit>
  void ForEach(Visit visit) const {
    for (std::size_t w = 0; w < words_.size(); ++w) {
      for (std::uint64_t left = words_[w]; left != 0; left &= left - 1) {
        visit(64 * w + static_cast<std::size_t>(std::countr_zero(left)));
      }
    }
  }

 private:
  std::vector<std::uint64_t> words_;
};

}  // namespace vps
