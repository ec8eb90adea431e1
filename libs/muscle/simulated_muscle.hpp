#pragma once

#include <array>
#include <cstdint>
#include <random>

#include "muscle/biquad.hpp"
#include "muscle/emg_frame.hpp"
#include "muscle/fault_watch.hpp"

namespace muscle {

// SIMULATED: the signals of a forearm that grips. Noise shaped to 20 to 450 Hz, as the sum of many motor units is,
// whose r.m.s. grows with the activation, differently at each electrode; beside it the noise of skin, some mains, and
// the slow drift of an electrode. Each channel can have a fault. The same seed gives the same signals.
class SimulatedMuscle {
 public:
  explicit SimulatedMuscle(std::uint64_t seed);

  // The next sample. `activation`: 0 to 1 of the strongest contraction, the truth that an estimate is measured by.
  EmgFrame Step(double activation);
  void SetFault(std::size_t channel, EmgFault fault) { channels_[channel].fault = fault; }
  static constexpr const char* kDescription = "SIMULATED muscle signals, of a generator";

  static constexpr double kMost_V = 300e-6;  // r.m.s. at the strongest contraction; at an electrode half to all of it
  static constexpr double kSkin_V = 5e-6;
  static constexpr double kMains_V = 2e-6;  // amplitude, without a fault
  static constexpr double kHum_V = 1.5e-3;  // amplitude, of the fault
  static constexpr double kDrift_V = 300e-6;
  static constexpr double kAmplifier_V = 0.5e-6;  // all that is left without an electrode

 private:
  struct Channel {
    double gain = 1.0;
    Biquad high_pass, low_pass;
    double drift_phase = 0.0;
    EmgFault fault = EmgFault::kNone;
  };
  double Sample(Channel* channel, double activation);

  std::mt19937_64 random_;
  std::normal_distribution<double> normal_{0.0, 1.0};
  std::array<Channel, kNumChannels> channels_;
  double shaped_rms_ = 1.0;  // of white noise after shaping
  double time_s_ = 0.0;
};

}  // namespace muscle
