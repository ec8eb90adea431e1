#include "tactile/electro/limiter.hpp"

#include <algorithm>
#include <cmath>

namespace tactile {
namespace {

bool IsPositive(double value) {
  return std::isfinite(value) && value > 0.0;
}

// Weaker than any skin feels: no use in giving it.
constexpr double kLeastCurrent_A = 1e-6;

}  // namespace

const char* NameOf(StopCause cause) {
  switch (cause) {
    case StopCause::kNothing:
      return "";
    case StopCause::kImpedanceJumped:
      return "stopped, as impedance jumped";
    case StopCause::kOpenElectrode:
      return "stopped by an open electrode";
    case StopCause::kNotProvedSafe:
      return "stopped, as it was not proved safe";
    case StopCause::kSilence:
      return "silent";
  }
  return "";
}

bool IsUsable(const SkinCalibration& c) {
  return IsPositive(c.threshold_A) && IsPositive(c.comfort_A) && IsPositive(c.pain_A) && c.threshold_A < c.comfort_A &&
         c.comfort_A < Limiter::kShareOfPain * c.pain_A;
}

core::Result<Limiter> Limiter::Create(const StimulationLimits& limits) {
  constexpr StimulationLimits kMost;
  const std::pair<double, double> all[] = {{limits.peak_A, kMost.peak_A},     {limits.width_s, kMost.width_s},
                                           {limits.charge_C, kMost.charge_C}, {limits.rms_A_per_m2, kMost.rms_A_per_m2},
                                           {limits.area_m2, kMost.area_m2},   {limits.rate_Hz, kMost.rate_Hz}};
  for (const auto& [value, most] : all) {
    if (IsPositive(value) && value <= most) continue;
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "a limit of the stimulator is " + std::to_string(value) +
                          ": it is above zero, and at most what StimulationLimits begins with");
  }
  return Limiter(limits);
}

void Limiter::Arm(std::int64_t now_ns) {
  if (is_armed_ || now_ns < 0) return;
  is_armed_ = true;
  armed_ns_ = now_ns;
}

// What was spent is kept: a person who disarms and arms again has no second one's heat more.
void Limiter::Disarm() {
  is_armed_ = false;
  stopped_by_ = StopCause::kNothing;
  for (Electrode& electrode : electrodes_) {
    electrode.impedance_Ohm = 0.0;
    electrode.is_fresh = false;
  }
}

bool Limiter::Calibrate(std::size_t electrode, const SkinCalibration& calibration) {
  Disarm();
  if (electrode >= kNumElectrodes) return false;
  electrodes_[electrode].calibration.reset();
  if (!IsUsable(calibration)) return false;
  electrodes_[electrode].calibration = calibration;
  return true;
}

void Limiter::Stop(StopCause cause) {
  if (stopped_by_ == StopCause::kNothing) stopped_by_ = cause;
}

void Limiter::TakeImpedance(std::size_t index, double impedance_Ohm) {
  if (index >= kNumElectrodes) return Stop(StopCause::kNotProvedSafe);
  Electrode& electrode = electrodes_[index];
  if (!IsPositive(impedance_Ohm) || impedance_Ohm > kOpen_Ohm) return Stop(StopCause::kOpenElectrode);
  const double before_Ohm = electrode.impedance_Ohm;
  const bool has_jumped = before_Ohm > 0.0 && (impedance_Ohm > kMostJump * before_Ohm ||  //
                                               before_Ohm > kMostJump * impedance_Ohm);
  if (has_jumped || impedance_Ohm < kShort_Ohm) return Stop(StopCause::kImpedanceJumped);
  electrode.impedance_Ohm = impedance_Ohm;
  electrode.is_fresh = true;
}

bool Limiter::IsProvedSafe(std::int64_t now_ns, std::size_t index, const Pulse& wanted) const {
  const Electrode& electrode = electrodes_[index];
  if (!electrode.calibration || !electrode.is_fresh) return false;
  if (!IsPositive(wanted.current_A) || !IsPositive(wanted.width_s) || wanted.width_s > limits_.width_s) return false;
  if (now_ns < armed_ns_) return false;
  if (has_pulsed_ && now_ns - pulsed_ns_ < kApart_ns) return false;
  const auto apart_ns = static_cast<std::int64_t>(std::ceil(1e9 / limits_.rate_Hz));
  return !electrode.has_pulsed || now_ns - electrode.pulsed_ns >= apart_ns;
}

double Limiter::Ceiling_A(std::int64_t now_ns, const Electrode& electrode) const {
  const double most_A = std::min(limits_.peak_A, kShareOfPain * electrode.calibration->pain_A);
  const double ramp = static_cast<double>(now_ns - armed_ns_) / static_cast<double>(kRamp_ns);
  return std::clamp(ramp, 0.0, 1.0) * most_A;
}

// Of any second that ends now, what pulses in it have not spent of
//   (rms density x area)^2 x 1 s.
double Limiter::HeatLeft_A2s(std::int64_t now_ns, Electrode* electrode) const {
  while (electrode->count > 0 && now_ns - electrode->spent[electrode->first].time_ns > kWindow_ns) {
    electrode->first = (electrode->first + 1) % kMostPulses;
    --electrode->count;
  }
  if (electrode->count == kMostPulses) return 0.0;
  const double rms_A = limits_.rms_A_per_m2 * limits_.area_m2;
  double left_A2s = rms_A * rms_A * static_cast<double>(kWindow_ns) * 1e-9;
  for (std::size_t i = 0; i < electrode->count; ++i) {
    left_A2s -= electrode->spent[(electrode->first + i) % kMostPulses].A2s;
  }
  return std::max(0.0, left_A2s);
}

std::optional<Pulse> Limiter::Bound(std::int64_t now_ns, std::size_t index, const Pulse& wanted) {
  if (index >= kNumElectrodes || !is_armed_ || stopped_by_ != StopCause::kNothing) return std::nullopt;
  if (!IsProvedSafe(now_ns, index, wanted)) return std::nullopt;
  Electrode& electrode = electrodes_[index];
  const double heat_A2s = HeatLeft_A2s(now_ns, &electrode);
  Pulse pulse = wanted;
  pulse.current_A = std::min({wanted.current_A, Ceiling_A(now_ns, electrode), limits_.charge_C / wanted.width_s,
                              std::sqrt(heat_A2s / (2.0 * wanted.width_s))});
  if (pulse.current_A < kLeastCurrent_A) return std::nullopt;
  const double A2s = pulse.current_A * pulse.current_A * 2.0 * pulse.width_s;
  electrode.spent[(electrode.first + electrode.count) % kMostPulses] = {now_ns, A2s};
  ++electrode.count;
  electrode.pulsed_ns = pulsed_ns_ = now_ns;
  electrode.has_pulsed = has_pulsed_ = true;
  electrode.is_fresh = false;
  return pulse;
}

}  // namespace tactile
