#pragma once

#include <array>
#include <string>

namespace core {

// device_bridge's figures that tell a person who steers a hand where it goes next: the kind, way and turn from where
// the hand is, and the opening of the jaws.
enum class GuideKind { kNone = 0, kMove = 1, kOpen = 2, kClose = 3, kWait = 4 };
inline constexpr std::array<const char*, 7> kGuideFigures = {"kind",         "way_x_W_m",    "way_y_W_m",   "way_z_W_m",
                                                             "turn_x_W_rad", "turn_y_W_rad", "turn_z_W_rad"};
inline std::string GuideName(const std::string& role, const char* figure) {
  return "guide." + role + "." + figure;
}

}  // namespace core
