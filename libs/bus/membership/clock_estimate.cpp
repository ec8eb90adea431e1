#include "bus/membership/clock_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bus::detail {
namespace {

constexpr std::int64_t kBucket_ns = 500'000'000;  // of the fit, which takes the best sample of each: ten heartbeats
constexpr int kMinBuckets = 4;                    // for a slope: 2 s of heartbeats

}  // namespace

bool ClockEstimate::Add(const ClockExchange& exchange) {
  const std::int64_t span = exchange.received_ns - exchange.sent_ns;
  const std::int64_t held = exchange.peer_sent_ns - exchange.peer_received_ns;
  const double slack = kMaxDrift * static_cast<double>(std::max<std::int64_t>(span, 0));
  if (span < 0 || held < 0 || static_cast<double>(held - span) > slack) return false;
  // Differences first: the clocks have arbitrary origins, and a sum of two stamps may overflow.
  const std::int64_t there = exchange.peer_received_ns - exchange.sent_ns;
  const std::int64_t back = exchange.peer_sent_ns - exchange.received_ns;
  Sample sample;
  sample.time_ns = exchange.received_ns;
  sample.offset_ns = there + (back - there) / 2;
  sample.bound_ns = static_cast<double>(std::max<std::int64_t>(span - held, 0)) / 2.0 + 1.5 * slack + 1.0;
  samples_[next_] = sample;
  next_ = (next_ + 1) % kWindow;
  size_ = std::min(size_ + 1, kWindow);
  ++num_exchanges_;
  if (const Interval all = Intersect(sample.time_ns); all.low > all.high) {
    samples_[0] = sample;
    size_ = next_ = 1;
    ++num_restarts_;
  }
  return true;
}

ClockEstimate::Interval ClockEstimate::Intersect(std::int64_t time_ns) const {
  Interval all{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  const std::int64_t base = newest().offset_ns;
  for (std::size_t i = 0; i < size_; ++i) {
    const Sample& sample = samples_[i];
    const double middle = static_cast<double>(sample.offset_ns - base);
    const double half = sample.bound_ns + kMaxDrift * static_cast<double>(time_ns - sample.time_ns);
    all.low = std::max(all.low, middle - half);
    all.high = std::min(all.high, middle + half);
  }
  return all;
}

// Weighted least squares over the best sample of each bucket, weight 1/bound^2. With fewer than kMinBuckets: the best
// sample of all, and slope 0.
ClockEstimate::Line ClockEstimate::Fit() const {
  const Sample& last = newest();
  double weight = 0.0, sum_t = 0.0, sum_o = 0.0, sum_tt = 0.0, sum_to = 0.0;
  int buckets = 0;
  const Sample* best = nullptr;
  const Sample* best_of_all = &last;
  const auto take = [&](const Sample& sample) {
    const double w = 1.0 / (sample.bound_ns * sample.bound_ns);
    const auto t = static_cast<double>(sample.time_ns - last.time_ns);
    const auto o = static_cast<double>(sample.offset_ns - last.offset_ns);
    weight += w;
    sum_t += w * t;
    sum_o += w * o;
    sum_tt += w * t * t;
    sum_to += w * t * o;
    ++buckets;
  };
  for (std::size_t i = 0; i < size_; ++i) {  // oldest first
    const Sample& sample = samples_[(next_ + kWindow - size_ + i) % kWindow];
    if (best != nullptr && best->time_ns / kBucket_ns != sample.time_ns / kBucket_ns) {
      take(*best);
      best = nullptr;
    }
    if (best == nullptr || sample.bound_ns < best->bound_ns) best = &sample;
    if (sample.bound_ns < best_of_all->bound_ns) best_of_all = &sample;
  }
  take(*best);
  const double determinant = weight * sum_tt - sum_t * sum_t;
  if (buckets < kMinBuckets || determinant <= 0.0) {
    return {static_cast<double>(best_of_all->offset_ns - last.offset_ns), 0.0};
  }
  const double slope = std::clamp((weight * sum_to - sum_t * sum_o) / determinant, -kMaxDrift, kMaxDrift);
  return {(sum_o - slope * sum_t) / weight, slope};
}

ClockReading ClockEstimate::At(std::int64_t time_ns) const {
  if (size_ == 0) return {0, kUnknownBound_ns, 0.0};
  const Interval all = Intersect(time_ns);
  const Line line = Fit();
  const double fitted = line.offset_ns + line.slope * static_cast<double>(time_ns - newest().time_ns);
  const double offset = std::clamp(fitted, all.low, all.high);
  ClockReading reading;
  reading.offset_ns = newest().offset_ns + std::llround(offset);
  reading.bound_ns = static_cast<std::int64_t>(std::ceil(std::max(all.high - offset, offset - all.low))) + 1;
  reading.drift_ppm = line.slope * 1e6;
  return reading;
}

}  // namespace bus::detail
