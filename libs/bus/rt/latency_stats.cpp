#include "bus/rt/latency_stats.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace bus {

// Values below 32 have a bin each. Above, with e = floor(log2 v): the 5 bits below the leading one pick the bin in its
// octave, so bins are 2^(e-5) wide and start at v >= 2^e: relative width at most 1/32.
int LatencyStats::BinOf(std::uint64_t value) {
  if (value < kBinsPerOctave) return static_cast<int>(value);
  const int exponent = std::bit_width(value) - 1;
  const int within = static_cast<int>((value >> (exponent - 5)) & 31);
  return std::min((exponent - 4) * kBinsPerOctave + within, kNumBins - 1);
}

double LatencyStats::UpperBound(int bin) {
  if (bin < kBinsPerOctave) return bin;
  const int exponent = bin / kBinsPerOctave + 4;
  const int within = bin % kBinsPerOctave;
  return std::ldexp(32.0 + within + 1.0, exponent - 5) - 1.0;  // the largest integer in the bin
}

void LatencyStats::Add(std::int64_t duration_ns) {
  const std::int64_t value = std::max<std::int64_t>(duration_ns, 0);
  ++bins_[static_cast<std::size_t>(BinOf(static_cast<std::uint64_t>(value)))];
  min_ns_ = count_ == 0 ? value : std::min(min_ns_, value);
  max_ns_ = std::max(max_ns_, value);
  sum_ns_ += static_cast<double>(value);
  ++count_;
}

void LatencyStats::Merge(const LatencyStats& other) {
  if (other.count_ == 0) return;
  for (std::size_t i = 0; i < bins_.size(); ++i) bins_[i] += other.bins_[i];
  min_ns_ = count_ == 0 ? other.min_ns_ : std::min(min_ns_, other.min_ns_);
  max_ns_ = std::max(max_ns_, other.max_ns_);
  sum_ns_ += other.sum_ns_;
  count_ += other.count_;
}

void LatencyStats::Clear() {
  *this = LatencyStats{};
}

double LatencyStats::mean_ns() const {
  return count_ == 0 ? 0.0 : sum_ns_ / static_cast<double>(count_);
}

double LatencyStats::Percentile_ns(double fraction) const {
  if (count_ == 0) return 0.0;
  const double wanted = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(count_);
  const auto rank = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil(wanted)));
  std::uint64_t below = 0;
  for (int bin = 0; bin < kNumBins; ++bin) {
    below += bins_[static_cast<std::size_t>(bin)];
    if (below >= rank) return std::min(UpperBound(bin), static_cast<double>(max_ns_));
  }
  return static_cast<double>(max_ns_);
}

}  // namespace bus
