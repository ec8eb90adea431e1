#pragma once

#include "core/messages/device.hpp"
#include "scene/scenario.hpp"
#include "view/scene.hpp"

namespace view {

// What a tactile device does, as a ring of points round its body, one for each channel: grey while it is off, amber
// when it is at its strongest. X_WO: of the body.
void AddTactileRing(const core::TactileState& state, const scene::Tactile& tactile, const core::Pose& X_WO,
                    Scene* scene);

// A line of text: what it is, how it is, how strong it is. Red while there is something wrong.
TextLine TactileLine(const core::TactileState& state, const scene::Tactile& tactile);

}  // namespace view
