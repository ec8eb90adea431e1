#pragma once

#include <array>
#include <optional>

#include "muscle/biquad.hpp"
#include "muscle/emg_frame.hpp"
#include "muscle/fault_watch.hpp"

namespace muscle {

// Of one person, each channel's envelope [V].
struct EmgCalibration {
  EmgFrame rest_V{};
  EmgFrame most_V{};  // at the strongest voluntary contraction
};

// From raw signals to how strongly a person grips: band-pass 20 to 450 Hz, rectified, smoothed at 2.5 Hz, between rest
// and the strongest contraction, as the mean of the channels without a fault.
class ForceEstimate {
 public:
  ForceEstimate();

  void Step(const EmgFrame& raw_V);
  void Calibrate(const EmgCalibration& calibration) { calibration_ = calibration; }

  // 0 to 1 of the strongest contraction. None: not calibrated, or more than half of the channels have faults; then
  // nobody may act on it.
  [[nodiscard]] std::optional<double> share() const;
  [[nodiscard]] EmgFault fault(std::size_t channel) const { return channels_[channel].watch.fault(); }
  [[nodiscard]] int num_faults() const;
  [[nodiscard]] EmgFrame envelopes_V() const;

  static constexpr double kLow_Hz = 20.0;    // below are movements of cables and skin
  static constexpr double kHigh_Hz = 450.0;  // above a muscle has nothing
  static constexpr double kSmooth_Hz = 2.5;

 private:
  struct Channel {
    Biquad high_pass, low_pass, smooth;
    FaultWatch watch;
    double envelope_V = 0.0;
  };
  std::array<Channel, kNumChannels> channels_;
  std::optional<EmgCalibration> calibration_;
};

// A person rests, then grips as hard as possible, three seconds each, and of each the last two count. Feed it from the
// start of each part.
class EmgCalibrator {
 public:
  enum class Part { kRest, kMost };
  void Add(Part part, const EmgFrame& envelopes_V);
  // None: too short, or a channel's strongest contraction is not three times its rest.
  [[nodiscard]] std::optional<EmgCalibration> result() const;

  static constexpr int kSettle = 1000;  // samples of a part that do not count
  static constexpr int kLeast = 2000;   // that must follow
  static constexpr double kLeastRatio = 3.0;

 private:
  struct Sum {
    int num_seen = 0;
    EmgFrame sum_V{};
  };
  std::array<Sum, 2> parts_;
};

// The strength of a grip [N] from the share: proportional. It begins above 0.1 and ends below 0.05, so that a hand that
// rests does not chatter. No share: no strength.
class GripMap {
 public:
  explicit GripMap(double most_N) : most_N_(most_N) {}
  double Step(const std::optional<double>& share);

  static constexpr double kBegin = 0.1;
  static constexpr double kEnd = 0.05;

 private:
  double most_N_;
  bool grips_ = false;
};

}  // namespace muscle
