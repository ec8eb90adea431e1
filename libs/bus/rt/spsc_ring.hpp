#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace bus {

// Bounded wait-free queue from one thread to one other. Overflow is refused and counted. Slots are reused, so a T whose
// buffers were reserved by `prepare` does not allocate while its contents fit.
template <class T>
class SpscRing {
 public:
  explicit SpscRing(std::size_t capacity) : slots_(capacity + 1) {}
  // Calls prepare(slot) on every slot, e.g. to reserve a string.
  template <class F>
  SpscRing(std::size_t capacity, F prepare) : slots_(capacity + 1) {
    for (T& slot : slots_) prepare(slot);
  }

  // Producer: the slot to fill, or null when full (counted). Visible to the consumer after EndPush().
  T* BeginPush() {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (Next(tail) == head_.load(std::memory_order_acquire)) {
      overflows_.fetch_add(1, std::memory_order_relaxed);
      return nullptr;
    }
    return &slots_[tail];
  }
  void EndPush() { tail_.store(Next(tail_.load(std::memory_order_relaxed)), std::memory_order_release); }
  bool Push(const T& value) {
    T* slot = BeginPush();
    if (slot == nullptr) return false;
    *slot = value;
    EndPush();
    return true;
  }

  // Consumer: the oldest, or null when empty. Its slot may be reused after EndPop().
  T* Front() {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    return head == tail_.load(std::memory_order_acquire) ? nullptr : &slots_[head];
  }
  void EndPop() { head_.store(Next(head_.load(std::memory_order_relaxed)), std::memory_order_release); }
  bool Pop(T* value) {
    T* slot = Front();
    if (slot == nullptr) return false;
    *value = *slot;
    EndPop();
    return true;
  }

  [[nodiscard]] std::uint64_t overflows() const { return overflows_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::size_t capacity() const { return slots_.size() - 1; }

 private:
  [[nodiscard]] std::size_t Next(std::size_t i) const { return i + 1 == slots_.size() ? 0 : i + 1; }
  std::vector<T> slots_;
  alignas(64) std::atomic<std::size_t> head_{0};
  alignas(64) std::atomic<std::size_t> tail_{0};
  std::atomic<std::uint64_t> overflows_{0};
};

}  // namespace bus
