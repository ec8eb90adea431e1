#pragma once

#include <cstdint>

#include "view/scene.hpp"

namespace view {

// Digest of a scene. Every viewer publishes it in figures/<its name> as kSceneDigestFigure, so that viewers can be
// compared with each other and with what was sent. It covers poses and sheets (rounded to 1 um), lamps, step and end,
// but not arrows, which expire, nor texts, which contain times. 48 bits, because the figure is a double.
std::uint64_t SceneDigest(const Scene& scene);

inline constexpr const char* kSceneDigestFigure = "scene_digest";

}  // namespace view
