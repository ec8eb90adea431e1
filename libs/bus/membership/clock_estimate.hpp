#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace bus::detail {

// One exchange with a peer, as in NTP [RFC 5905, section 8]. t1 and t4 are of our clock, t2 and t3 of the peer's.
struct ClockExchange {
  std::int64_t sent_ns = 0;           // t1, ours
  std::int64_t peer_received_ns = 0;  // t2, the peer's
  std::int64_t peer_sent_ns = 0;      // t3, the peer's
  std::int64_t received_ns = 0;       // t4, ours
};

struct ClockReading {
  std::int64_t offset_ns = 0;  // peer's clock minus ours
  std::int64_t bound_ns = 0;   // the true offset is within offset_ns +- bound_ns; kUnknownBound_ns: unknown
  double drift_ppm = 0.0;      // of the peer's clock against ours, fitted; an estimate without bound
};
constexpr std::int64_t kUnknownBound_ns = INT64_MAX;

// Assumed limit of the difference in rate between two clocks [s/s]: quartz is within 100 ppm, and NTP slews by up to
// 500 ppm. A violation shows as intervals without intersection, and restarts the estimate.
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
// so the left side of the second line differs from theta(t4) by at most rtt/2 + rho (s3 - s2)/2 + rho (t4 - s2), that
// is by at most
//
//   rtt/2 + 3/2 rho (t4 - t1),                                                                                   (1)
//
// and by rho (t - t4) more at a later t. Every exchange gives such an interval, and theta lies in the intersection of
// all. Exchanges with a short round trip give the narrow intervals, so the intersection is NTP's minimum filter with a
// proven bound. Within it the estimate follows a line fitted to the best exchange of each half second, which removes
// the drift; where the line leaves the intersection, the estimate is clamped to it.
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
    double low = 0.0, high = 0.0;  // of the offset, relative to the newest sample's
  };
  struct Line {
    double offset_ns = 0.0;  // relative to the newest sample's, at its time
    double slope = 0.0;
  };
  [[nodiscard]] const Sample& newest() const { return samples_[(next_ + kWindow - 1) % kWindow]; }
  [[nodiscard]] Interval Intersect(std::int64_t time_ns) const;
  [[nodiscard]] Line Fit() const;

  // 13 s of heartbeats. An older interval has grown by more than 6 ms (kMaxDrift), and no longer narrows the estimate.
  static constexpr std::size_t kWindow = 256;
  std::array<Sample, kWindow> samples_{};
  std::size_t size_ = 0, next_ = 0;
  std::uint64_t num_exchanges_ = 0;
  std::uint32_t num_restarts_ = 0;
};

}  // namespace bus::detail
