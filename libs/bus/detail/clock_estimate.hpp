#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace bus::detail {

// One exchange with a peer, after NTP [RFC 5905, section 8]. Each pair of stamps is of one clock.
struct ClockExchange {
  std::int64_t sent_ns = 0;           // t1, ours
  std::int64_t peer_received_ns = 0;  // t2, the peer's
  std::int64_t peer_sent_ns = 0;      // t3, the peer's
  std::int64_t received_ns = 0;       // t4, ours
};

struct ClockReading {
  std::int64_t offset_ns = 0;  // peer's clock minus ours
  std::int64_t bound_ns = 0;   // the true offset is within offset_ns +- bound_ns; kUnknownBound_ns: nothing is known
  double drift_ppm = 0.0;      // of the peer's clock against ours, fitted; only an estimate
};
constexpr std::int64_t kUnknownBound_ns = INT64_MAX;

// Quartz is within 100 ppm, and NTP slews it by some more: two clocks are taken to differ in rate by no more than this.
// A violation shows, as intervals that contradict each other, and starts the estimate anew.
constexpr double kMaxDrift = 5e-4;

// Offset of a peer's clock with a bound that holds whatever the path does.
//
// With theta(t) = peer's clock - ours at our time t, |theta'| <= rho, the way there d1 >= 0 and back d2 >= 0, and s2,
// s3 our times when the peer received and answered:
//
//   t2 = s2 + theta(s2),  t3 = s3 + theta(s3),  d1 = s2 - t1,  d2 = t4 - s3
//   ((t2 - t1) + (t3 - t4)) / 2 = (d1 - d2) / 2 + (theta(s2) + theta(s3)) / 2
//   rtt = (t4 - t1) - (t3 - t2) = d1 + d2 - (theta(s3) - theta(s2))
//
// so the left side of the second line differs from theta(t4) by at most rtt/2 + rho (s3 - s2)/2 + rho (t4 - s2), hence
// by
//
//   rtt/2 + 3/2 rho (t4 - t1),                                                                                   (1)
//
// and by rho (t - t4) more at a later t. Every exchange gives such an interval; all hold at once, so theta lies in
// their intersection. Those with the smallest round trip are the narrow ones: the intersection is the minimum filter of
// NTP with a proof. Within it the estimate follows a line fitted to the best exchange of each half second, which takes
// the drift out; where the line leaves the intersection it is cut.
class ClockEstimate {
 public:
  // Exchanges that contradict causality (a negative round trip) are refused: false.
  bool Add(const ClockExchange& exchange);
  [[nodiscard]] ClockReading At(std::int64_t time_ns) const;  // ours, not before the last exchange
  [[nodiscard]] std::uint64_t num_exchanges() const { return num_exchanges_; }
  [[nodiscard]] std::uint32_t num_restarts() const { return num_restarts_; }  // intervals that contradicted

 private:
  struct Sample {
    std::int64_t time_ns = 0;  // t4
    std::int64_t offset_ns = 0;
    double bound_ns = 0.0;  // by (1)
  };
  struct Interval {
    double low = 0.0, high = 0.0;  // of the offset, against the newest sample's
  };
  struct Line {
    double offset_ns = 0.0;  // against the newest sample's, at its time
    double slope = 0.0;
  };
  [[nodiscard]] const Sample& newest() const { return samples_[(next_ + kWindow - 1) % kWindow]; }
  [[nodiscard]] Interval Intersect(std::int64_t time_ns) const;
  [[nodiscard]] Line Fit() const;

  static constexpr std::size_t kWindow = 256;  // 13 s of heartbeats
  std::array<Sample, kWindow> samples_{};
  std::size_t size_ = 0, next_ = 0;
  std::uint64_t num_exchanges_ = 0;
  std::uint32_t num_restarts_ = 0;
};

}  // namespace bus::detail
