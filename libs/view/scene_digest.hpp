#pragma once

#include <cstdint>

#include "view/scene.hpp"

namespace view {

// What a viewer says that it shows, as a number: every viewer puts it into figures/<its name> as kSceneDigestFigure, so
// that viewers can be compared with each other and with what was sent. Poses and sheets to 1 um, lamps, step and end;
// neither the arrows, which age, nor lines of text with times in them. 48 bits, which a double holds exactly.
std::uint64_t SceneDigest(const Scene& scene);

inline constexpr const char* kSceneDigestFigure = "scene_digest";

}  // namespace view
