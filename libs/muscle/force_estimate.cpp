#include "muscle/force_estimate.hpp"

#include <algorithm>
#include <cmath>

namespace muscle {

ForceEstimate::ForceEstimate() {
  for (Channel& channel : channels_) {
    channel.high_pass = Biquad::HighPass(kLow_Hz, kSample_s);
    channel.low_pass = Biquad::LowPass(kHigh_Hz, kSample_s);
    channel.smooth = Biquad::LowPass(kSmooth_Hz, kSample_s);
  }
}

// What is no number would stay in the filters for ever.
void ForceEstimate::Step(const EmgFrame& raw_V) {
  for (std::size_t i = 0; i < kNumChannels; ++i) {
    Channel& channel = channels_[i];
    const double taken_V = std::isfinite(raw_V[i]) ? std::clamp(raw_V[i], -kFullScale_V, kFullScale_V) : 0.0;
    const double band_V = channel.low_pass.Step(channel.high_pass.Step(taken_V));
    channel.envelope_V = channel.smooth.Step(std::abs(band_V));
    channel.watch.Step(raw_V[i], band_V);
  }
}

std::optional<double> ForceEstimate::share() const {
  if (!calibration_) return std::nullopt;
  double sum = 0.0;
  int num_good = 0;
  for (std::size_t i = 0; i < kNumChannels; ++i) {
    if (channels_[i].watch.fault() != EmgFault::kNone) continue;
    const double range_V = calibration_->most_V[i] - calibration_->rest_V[i];
    sum += (channels_[i].envelope_V - calibration_->rest_V[i]) / range_V;
    ++num_good;
  }
  if (2 * num_good < static_cast<int>(kNumChannels)) return std::nullopt;
  return std::clamp(sum / num_good, 0.0, 1.0);
}

int ForceEstimate::num_faults() const {
  return static_cast<int>(std::count_if(channels_.begin(), channels_.end(), [](const Channel& channel) {
    return channel.watch.fault() != EmgFault::kNone;
  }));
}

EmgFrame ForceEstimate::envelopes_V() const {
  EmgFrame envelopes_V{};
  for (std::size_t i = 0; i < kNumChannels; ++i) envelopes_V[i] = channels_[i].envelope_V;
  return envelopes_V;
}

void EmgCalibrator::Add(Part part, const EmgFrame& envelopes_V) {
  Sum& sum = parts_[static_cast<std::size_t>(part)];
  if (++sum.num_seen <= kSettle) return;
  for (std::size_t i = 0; i < kNumChannels; ++i) sum.sum_V[i] += envelopes_V[i];
}

std::optional<EmgCalibration> EmgCalibrator::result() const {
  EmgCalibration calibration;
  for (const Sum& part : parts_) {
    if (part.num_seen < kSettle + kLeast) return std::nullopt;
  }
  for (std::size_t i = 0; i < kNumChannels; ++i) {
    calibration.rest_V[i] = parts_[0].sum_V[i] / (parts_[0].num_seen - kSettle);
    calibration.most_V[i] = parts_[1].sum_V[i] / (parts_[1].num_seen - kSettle);
    const bool is_usable = calibration.rest_V[i] > 0.0 && calibration.most_V[i] >= kLeastRatio * calibration.rest_V[i];
    if (!is_usable) return std::nullopt;
  }
  return calibration;
}

double GripMap::Step(const std::optional<double>& share) {
  const double value = share.value_or(0.0);
  grips_ = value > (grips_ ? kEnd : kBegin);
  return grips_ ? most_N_ * value : 0.0;
}

}  // namespace muscle
