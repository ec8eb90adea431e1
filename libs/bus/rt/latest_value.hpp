#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace bus {

// Newest value from one writer thread to one reader thread: a triple buffer, wait-free at both ends, never torn. Each
// side owns one slot; the third changes hands by one atomic exchange. Bit 2 of the exchanged word marks a new value.
template <class T>
class LatestValue {
 public:
  // Writer: fill the slot in place (its old content is some earlier value), then publish it.
  T& BeginWrite() { return slots_[back_]; }
  void EndWrite() {
    ++written_;
    sequence_[back_] = written_;
    back_ = middle_.exchange(back_ | kNew, std::memory_order_acq_rel) & kIndex;
  }
  void Write(const T& value) {
    BeginWrite() = value;
    EndWrite();
  }

  // Reader: true when a newer value than before has been taken over.
  bool Update() {
    if ((middle_.load(std::memory_order_relaxed) & kNew) == 0) return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return true;
  }
  const T& value() const { return slots_[front_]; }
  // Number of the value taken over last; 0: none yet.
  [[nodiscard]] std::uint64_t sequence() const { return sequence_[front_]; }

 private:
  static constexpr std::uint32_t kNew = 4;
  static constexpr std::uint32_t kIndex = 3;
  std::array<T, 3> slots_{};
  std::array<std::uint64_t, 3> sequence_{};
  alignas(64) std::atomic<std::uint32_t> middle_{1};
  alignas(64) std::uint32_t back_ = 0;
  std::uint64_t written_ = 0;
  alignas(64) std::uint32_t front_ = 2;
};

}  // namespace bus
