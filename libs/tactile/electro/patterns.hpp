#pragma once

#include <array>
#include <cstdint>

#include "tactile/electro/finger_contact.hpp"
#include "tactile/electro/limiter.hpp"

namespace tactile {

// Kinds of contact that electrodes let a person tell apart [VR-OOS, section 4].
enum class ContactKind : std::uint8_t { kNone, kTouch, kPressure, kSlip, kMovement };
const char* NameOf(ContactKind kind);

// Tells kinds of contact apart. A touch is how a contact begins; then what is under the finger slides over the skin
// (slip), or rolls on so that its place travels (movement), or presses.
class ContactClassifier {
 public:
  ContactKind Step(std::int64_t now_ns, const FingerContact& contact);

  // Since when the finger has touched something, or nothing.
  [[nodiscard]] std::int64_t since_ns() const { return since_ns_; }

  static constexpr std::int64_t kTouch_ns = 100'000'000;
  static constexpr double kMoving_m_per_s = 0.005;  // slower, a fingertip does not tell it from rest
  static constexpr double kSmoothing_s = 0.02;      // of both speeds: contact points jump between a part's samples

 private:
  bool touches_ = false;
  std::int64_t since_ns_ = 0;
  std::int64_t before_ns_ = 0;
  glm::dvec2 slip_m_per_s_{0.0}, travel_m_per_s_{0.0};
};

using ElectrodePlaces = std::array<glm::dvec2, kNumElectrodes>;  // on the pad [m]

// What an electrode does: how strong between threshold and comfort, and how often.
struct Tingle {
  double level = 0.0;  // 0: off
  double rate_Hz = 0.0;
};
using Pattern = std::array<Tingle, kNumElectrodes>;

// The electrodes near the place, at a rate of the kind's own: touch, bursts of six pulses at 350 Hz [Kaczmarek];
// pressure, a steady 30 Hz; movement, 60 Hz. Slip: 100 Hz in a wave over all electrodes, in its direction. `strength`:
// 0 to 1. `time_s`: since the contact began.
Pattern PatternOf(ContactKind kind, const FingerContact& contact, double strength, double time_s,
                  const ElectrodePlaces& places);

}  // namespace tactile
