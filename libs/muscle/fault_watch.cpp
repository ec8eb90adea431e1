#include "muscle/fault_watch.hpp"

#include <cmath>
#include <glm/gtc/constants.hpp>

namespace muscle {
namespace {

constexpr double kMains_Hz = 50.0;

}  // namespace

const char* NameOf(EmgFault fault) {
  switch (fault) {
    case EmgFault::kNone:
      return "";
    case EmgFault::kElectrodeOff:
      return "electrode off";
    case EmgFault::kSaturated:
      return "saturated";
    case EmgFault::kMainsHum:
      return "mains hum";
  }
  return "";
}

void FaultWatch::Step(double raw_V, double band_V) {
  const double phase = glm::two_pi<double>() * kMains_Hz * kSample_s * count_;
  cosine_V_ += band_V * std::cos(phase);
  sine_V_ += band_V * std::sin(phase);
  sum_V2_ += band_V * band_V;
  if (!(std::abs(raw_V) < 0.98 * kFullScale_V)) ++num_at_end_;  // also what is no number
  if (++count_ < kWindow) return;
  const EmgFault found = Judge();
  if (found == last_) fault_ = found;
  last_ = found;
  count_ = num_at_end_ = 0;
  sum_V2_ = cosine_V_ = sine_V_ = 0.0;
}

// A sine of amplitude A has A^2/2 of power, and A n/2 as the length of the two sums.
EmgFault FaultWatch::Judge() const {
  if (num_at_end_ > kSaturatedShare * kWindow) return EmgFault::kSaturated;
  const double power_V2 = sum_V2_ / kWindow;
  if (!(power_V2 >= kOff_V * kOff_V)) return EmgFault::kElectrodeOff;
  const double hum_V2 = 2.0 * (cosine_V_ * cosine_V_ + sine_V_ * sine_V_) / (double{kWindow} * kWindow);
  return hum_V2 > kHumShare * power_V2 ? EmgFault::kMainsHum : EmgFault::kNone;
}

}  // namespace muscle
