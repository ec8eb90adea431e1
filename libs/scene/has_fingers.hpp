#pragma once

#include <algorithm>

#include "scene/scenario.hpp"

namespace scene {

// Whether the hand of a role (index into Scenario::devices) has fingers, which hold by their contacts (decision 24).
inline bool HasFingers(const Scenario& scenario, int role) {
  return std::any_of(scenario.mechanisms.begin(), scenario.mechanisms.end(),
                     [&](const Mechanism& m) { return m.finger_role == role; });
}

}  // namespace scene
