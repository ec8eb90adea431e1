#pragma once

#include "core/messages/device.hpp"
#include "scene/scenario.hpp"
#include "view/scene.hpp"

namespace view {

// What a viewer says to the person who steers a hand by it.
struct SteeringState {
  core::HandInput input;
  bool has_gamepad = false;
  bool has_space_mouse = false;
  bool shows_next = false;  // where the hand goes next
};

// Lines at the bottom of the scene's texts: which hand is steered, what it feels, how to steer; with shows_next where
// it goes next, in the words of the keys that bring it there ("right 12.0, down 3.1 mm; Ctrl: left 4 deg"), a line from
// the hand to there, and a phantom of the palm. `camera`: placed in W.
void DescribeSteering(const scene::Scenario& scenario, const SteeringState& state, const scene::Camera& camera,
                      Scene* scene);

}  // namespace view
