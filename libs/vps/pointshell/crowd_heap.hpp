#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace vps {

// Binary heap of candidates by weight, the heaviest on top, ties by index; positions are known so weights can fall.
class CrowdHeap {
 public:
  explicit CrowdHeap(std::vector<double> weights)
      : weights_(std::move(weights)), heap_(weights_.size()), place_(weights_.size()) {
    for (std::uint32_t i = 0; i < heap_.size(); ++i) heap_[i] = place_[i] = i;
    for (std::size_t i = heap_.size() / 2; i-- > 0;) Sink(i);
  }
  std::uint32_t PopHeaviest() {
    const std::uint32_t top = heap_[0];
    Put(0, heap_.back());
    heap_.pop_back();
    place_[top] = kGone;
    if (!heap_.empty()) Sink(0);
    return top;
  }
  [[nodiscard]] bool contains(std::uint32_t item) const { return place_[item] != kGone; }
  void Lower(std::uint32_t item, double by) {
    weights_[item] -= by;
    Sink(place_[item]);
  }

 private:
  static constexpr std::uint32_t kGone = 0xffffffffU;
  [[nodiscard]] bool IsHeavier(std::uint32_t a, std::uint32_t b) const {
    return weights_[a] != weights_[b] ? weights_[a] > weights_[b] : a < b;
  }
  void Put(std::size_t at, std::uint32_t item) {
    heap_[at] = item;
    place_[item] = static_cast<std::uint32_t>(at);
  }
  void Sink(std::size_t at) {
    const std::uint32_t item = heap_[at];
    for (;;) {
      std::size_t child = 2 * at + 1;
      if (child >= heap_.size()) break;
      if (child + 1 < heap_.size() && IsHeavier(heap_[child + 1], heap_[child])) ++child;
      if (!IsHeavier(heap_[child], item)) break;
      Put(at, heap_[child]);
      at = child;
    }
    Put(at, item);
  }

  std::vector<double> weights_;
  std::vector<std::uint32_t> heap_, place_;
};

}  // namespace vps
