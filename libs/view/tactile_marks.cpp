#include "view/tactile_marks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/gtc/constants.hpp>

namespace view {
namespace {

constexpr double kRing_m = 0.04;  // radius, about that of a forearm
constexpr glm::vec3 kOffColor{0.25f, 0.28f, 0.32f};
constexpr glm::vec3 kOnColor{1.0f, 0.62f, 0.12f};
constexpr glm::vec3 kWrongColor{1.0f, 0.22f, 0.18f};

constexpr std::array kTactileStatuses = {"not there yet", "", "does not answer", "is gone"};
constexpr std::array kTactileStops = {"", "stopped, impedance jumped", "stopped, open electrode",
                                      "stopped, not proved safe", ""};
constexpr std::array kTactilePatterns = {"", "  touch", "  pressure", "  slip", "  movement"};

template <std::size_t kSize>
const char* NameAt(const std::array<const char*, kSize>& names, std::uint8_t index) {
  return index < kSize ? names[index] : "?";
}

std::string WhatIsWrong(const core::TactileState& state) {
  const std::string status = NameAt(kTactileStatuses, state.status);
  return status.empty() ? NameAt(kTactileStops, state.stopped_by) : status;
}

float Strongest(const core::TactileState& state) {
  float strongest = 0.0f;
  for (const core::TactileChannel& channel : state.channels) strongest = std::max(strongest, channel.level);
  return strongest;
}

}  // namespace

void AddTactileRing(const core::TactileState& state, const scene::Tactile& tactile, const core::Pose& X_WO,
                    Scene* scene) {
  std::vector<glm::vec3> places, colors;
  for (std::size_t i = 0; i < state.channels.size(); ++i) {
    const double angle = glm::two_pi<double>() * static_cast<double>(i) / static_cast<double>(state.channels.size());
    places.emplace_back(kRing_m * glm::dvec3(std::cos(angle), std::sin(angle), 0.0));
    colors.push_back(glm::mix(kOffColor, kOnColor, std::clamp(state.channels[i].level, 0.0f, 1.0f)));
  }
  PointSet points;
  points.X_WP = X_WO * tactile.X_OB;
  points.p_P = std::make_shared<const std::vector<glm::vec3>>(std::move(places));
  points.colors = std::make_shared<const std::vector<glm::vec3>>(std::move(colors));
  points.size_px = 6.0f;
  scene->points.push_back(std::move(points));
}

TextLine TactileLine(const core::TactileState& state, const scene::Tactile& tactile) {
  const std::string wrong = WhatIsWrong(state);
  char strength[48];
  std::snprintf(strength, sizeof strength, "%.0f %%", 100.0 * static_cast<double>(Strongest(state)));
  std::string line = tactile.name + (state.is_simulated ? " (SIMULATED)  " : "  ");
  line += wrong.empty() ? strength : wrong;
  if (wrong.empty()) line += NameAt(kTactilePatterns, state.pattern);
  return {Anchor::kTopLeft, TextStyle::kSmall, wrong.empty() ? kOnColor : kWrongColor, line};
}

}  // namespace view
