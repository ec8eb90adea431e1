#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <thread>

namespace bus::detail {

// A sequence lock: one thread writes a small value, any number of threads read it untorn. Writing is wait-free; a
// reader that overlaps a write retries. T: trivially copyable, a whole number of 64-bit words.
template <class T>
class Published {
 public:
  void Write(const T& value) noexcept {
    const auto words = std::bit_cast<Words>(value);
    const std::uint64_t version = version_.load(std::memory_order_relaxed);
    version_.store(version + 1, std::memory_order_relaxed);  // odd: a write is under way
    for (std::size_t i = 0; i < kNumWords; ++i) words_[i].store(words[i], std::memory_order_release);
    version_.store(version + 2, std::memory_order_release);
  }
  [[nodiscard]] T Read() const noexcept {
    Words words;
    for (;;) {
      const std::uint64_t before = version_.load(std::memory_order_acquire);
      for (std::size_t i = 0; i < kNumWords; ++i) words[i] = words_[i].load(std::memory_order_acquire);
      if (before % 2 == 0 && version_.load(std::memory_order_relaxed) == before) return std::bit_cast<T>(words);
      std::this_thread::yield();  // the writer may have lost its processor
    }
  }

 private:
  static constexpr std::size_t kNumWords = sizeof(T) / sizeof(std::uint64_t);
  static_assert(sizeof(T) % sizeof(std::uint64_t) == 0);
  using Words = std::array<std::uint64_t, kNumWords>;

  std::atomic<std::uint64_t> version_{0};
  std::array<std::atomic<std::uint64_t>, kNumWords> words_{};
};

}  // namespace bus::detail
