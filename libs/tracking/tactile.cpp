#include "tracking/tactile.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace tracking {
namespace {

// With a point for the decimals, whatever the locale.
std::string TwoDecimals(double value) {
  std::array<char, 16> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, 2);
  return std::string(text.data(), end);
}

}  // namespace

std::string TactileDatagram(std::span<const FingerVibration> fingers) {
  std::string text = "tfb " + std::to_string(fingers.size());
  for (const FingerVibration& finger : fingers) {
    const double strength = std::isfinite(finger.strength) ? std::clamp(finger.strength, 0.0, 1.0) : 0.0;
    text += " [" + std::to_string(finger.hand) + " " + std::to_string(finger.finger) + " 1.00 " +
            TwoDecimals(strength) + "]";
  }
  return text;
}

}  // namespace tracking
