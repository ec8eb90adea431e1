#include "tactile/electro/patterns.hpp"

#include <algorithm>
#include <cmath>

namespace tactile {
namespace {

constexpr double kReach_m = 0.004;  // an electrode farther from the place is off; electrodes are 3 mm apart
constexpr double kPulsesPerBurst = 6.0;
constexpr double kBurst_Hz = 350.0;
constexpr double kBursts_Hz = 15.0;
constexpr double kPressure_Hz = 30.0;
constexpr double kMovement_Hz = 60.0;
constexpr double kSlip_Hz = 100.0;
constexpr double kWave_m = 0.012;  // the pad's length
constexpr double kWaves_Hz = 4.0;

// Linear, so that a place between two electrodes is felt between them.
double Nearness(const glm::dvec2& place_m, const glm::dvec2& electrode_m) {
  return std::max(0.0, 1.0 - glm::distance(place_m, electrode_m) / kReach_m);
}

double Fraction(double value) {
  return value - std::floor(value);
}

// A third of the pad at a time, moving with what slips.
double Wave(const glm::dvec2& direction, const glm::dvec2& electrode_m, double time_s) {
  return Fraction(glm::dot(direction, electrode_m) / kWave_m - kWaves_Hz * time_s) < 1.0 / 3.0 ? 1.0 : 0.0;
}

}  // namespace

const char* NameOf(ContactKind kind) {
  constexpr const char* kNames[] = {"none", "touch", "pressure", "slip", "movement"};
  return kNames[static_cast<std::size_t>(kind)];
}

ContactKind ContactClassifier::Step(std::int64_t now_ns, const FingerContact& contact) {
  const bool touches = contact.depth_m > 0.0;
  if (touches != touches_) since_ns_ = now_ns;
  if (!touches || !touches_) slip_m_per_s_ = travel_m_per_s_ = glm::dvec2(0.0);
  touches_ = touches;
  const double share = 1.0 - std::exp(-static_cast<double>(now_ns - before_ns_) * 1e-9 / kSmoothing_s);
  before_ns_ = now_ns;
  if (!touches) return ContactKind::kNone;
  slip_m_per_s_ += share * (contact.slip_m_per_s - slip_m_per_s_);
  travel_m_per_s_ += share * (contact.travel_m_per_s - travel_m_per_s_);
  if (now_ns - since_ns_ < kTouch_ns) return ContactKind::kTouch;
  if (glm::length(slip_m_per_s_) > kMoving_m_per_s) return ContactKind::kSlip;
  return glm::length(travel_m_per_s_) > kMoving_m_per_s ? ContactKind::kMovement : ContactKind::kPressure;
}

Pattern PatternOf(ContactKind kind, const FingerContact& contact, double strength, double time_s,
                  const ElectrodePlaces& places) {
  Pattern pattern;
  if (kind == ContactKind::kNone) return pattern;
  const double speed = glm::length(contact.slip_m_per_s);
  const glm::dvec2 direction = speed > 0.0 ? contact.slip_m_per_s / speed : glm::dvec2(0.0, 1.0);
  const bool is_in_burst = Fraction(kBursts_Hz * time_s) < kPulsesPerBurst * kBursts_Hz / kBurst_Hz;
  for (std::size_t i = 0; i < kNumElectrodes; ++i) {
    const double near = strength * Nearness(contact.place_m, places[i]);
    switch (kind) {
      case ContactKind::kTouch:
        pattern[i] = {is_in_burst ? near : 0.0, kBurst_Hz};
        break;
      case ContactKind::kSlip:
        pattern[i] = {strength * Wave(direction, places[i], time_s), kSlip_Hz};
        break;
      case ContactKind::kMovement:
        pattern[i] = {near, kMovement_Hz};
        break;
      default:
        pattern[i] = {near, kPressure_Hz};
    }
  }
  return pattern;
}

}  // namespace tactile
