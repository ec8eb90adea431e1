#pragma once

#include <array>
#include <cstdint>

namespace bus {

// Distribution of durations in fixed memory: 32 bins per factor of two from 1 ns up to 2^40 ns (18 min), so a
// percentile is exact within 3.2 % (1/32); count, mean, min and max are exact. Add() does not allocate.
class LatencyStats {
 public:
  void Add(std::int64_t duration_ns);
  void Merge(const LatencyStats& other);
  void Clear();

  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double mean_ns() const;
  [[nodiscard]] std::int64_t min_ns() const { return count_ == 0 ? 0 : min_ns_; }
  [[nodiscard]] std::int64_t max_ns() const { return max_ns_; }
  // Smallest bin bound below which a part of at least `fraction` in [0, 1] lies; never above max_ns(). 0 when empty.
  [[nodiscard]] double Percentile_ns(double fraction) const;
  [[nodiscard]] double p50_ns() const { return Percentile_ns(0.5); }
  [[nodiscard]] double p90_ns() const { return Percentile_ns(0.9); }
  [[nodiscard]] double p99_ns() const { return Percentile_ns(0.99); }
  [[nodiscard]] double p999_ns() const { return Percentile_ns(0.999); }

 private:
  static constexpr int kBinsPerOctave = 32;
  static constexpr int kNumBins = 41 * kBinsPerOctave;
  static int BinOf(std::uint64_t value);
  static double UpperBound(int bin);

  std::array<std::uint64_t, kNumBins> bins_{};
  std::uint64_t count_ = 0;
  double sum_ns_ = 0.0;
  std::int64_t min_ns_ = 0;
  std::int64_t max_ns_ = 0;
};

}  // namespace bus
