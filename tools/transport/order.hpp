#pragma once

#include <cstddef>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

namespace transport {

// Permutations of 0 to size - 1, a new one each time, so that a busy moment of the machine affects all contenders alike
// and none always follows the same other one. Every run has the same sequence.
class Order {
 public:
  explicit Order(std::size_t size) : turns_(size) { std::iota(turns_.begin(), turns_.end(), std::size_t{0}); }
  const std::vector<std::size_t>& Next() {
    for (std::size_t i = turns_.size(); i > 1; --i) std::swap(turns_[i - 1], turns_[random_() % i]);
    return turns_;
  }

 private:
  std::vector<std::size_t> turns_;
  std::mt19937_64 random_{1};
};

}  // namespace transport
