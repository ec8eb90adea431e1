#include "muscle/simulated_muscle.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

namespace muscle {
namespace {

constexpr double kUnitsLow_Hz = 20.0;
constexpr double kUnitsHigh_Hz = 450.0;
constexpr double kDrift_Hz = 0.3;

double Sine(double frequency_Hz, double time_s, double phase) {
  return std::sin(glm::two_pi<double>() * frequency_Hz * time_s + phase);
}

// A filter's gain for white noise: the root of the sum of the squares of its impulse response.
double NoiseGain(Biquad high_pass, Biquad low_pass) {
  double sum = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double y = low_pass.Step(high_pass.Step(i == 0 ? 1.0 : 0.0));
    sum += y * y;
  }
  return std::sqrt(sum);
}

}  // namespace

SimulatedMuscle::SimulatedMuscle(std::uint64_t seed) : random_(seed) {
  std::uniform_real_distribution<double> gain(0.5, 1.0), phase(0.0, glm::two_pi<double>());
  for (Channel& channel : channels_) {
    channel.gain = gain(random_);
    channel.drift_phase = phase(random_);
    channel.high_pass = Biquad::HighPass(kUnitsLow_Hz, kSample_s);
    channel.low_pass = Biquad::LowPass(kUnitsHigh_Hz, kSample_s);
  }
  shaped_rms_ = NoiseGain(channels_[0].high_pass, channels_[0].low_pass);
}

EmgFrame SimulatedMuscle::Step(double activation) {
  EmgFrame frame{};
  for (std::size_t i = 0; i < kNumChannels; ++i) frame[i] = Sample(&channels_[i], std::clamp(activation, 0.0, 1.0));
  time_s_ += kSample_s;
  return frame;
}

double SimulatedMuscle::Sample(Channel* channel, double activation) {
  const double units = channel->low_pass.Step(channel->high_pass.Step(normal_(random_))) / shaped_rms_;
  double sample_V = kMost_V * channel->gain * activation * units + kSkin_V * normal_(random_) +
                    kMains_V * Sine(50.0, time_s_, 0.0) + kDrift_V * Sine(kDrift_Hz, time_s_, channel->drift_phase);
  switch (channel->fault) {
    case EmgFault::kNone:
      break;
    case EmgFault::kElectrodeOff:
      sample_V = kAmplifier_V * normal_(random_);
      break;
    case EmgFault::kSaturated:
      sample_V += 2.0 * kFullScale_V;
      break;
    case EmgFault::kMainsHum:
      sample_V += kHum_V * Sine(50.0, time_s_, 0.5);
      break;
  }
  return std::clamp(sample_V, -kFullScale_V, kFullScale_V);
}

}  // namespace muscle
