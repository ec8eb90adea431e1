#pragma once

#include <cstdint>

#include "core/messages/rays.hpp"
#include "core/result.hpp"
#include "tiles/quality.hpp"
#include "view/appearance/environment_light.hpp"
#include "view/scene.hpp"

namespace tiles {

// What of a scene its light and depths depend on, for a message. `placed` is in W. What is over the scene (arrows,
// captions) and far away (stars, Earth) is not in it.
core::RayFrame EncodeFrame(const view::Scene& scene, const view::EnvironmentLight& light, const scene::Camera& placed,
                           int width, int height);

// Puts a frame's things where it has them. `scene` has been made of the same scenario. False, and the scene is
// unchanged, when it has other parts: the frame is of another scenario.
bool ApplyFrame(const core::RayFrame& frame, view::Scene* scene);
view::EnvironmentLight LightOf(const core::RayFrame& frame);
Quality QualityOf(const core::RayFrame& frame);

// Frames with equal numbers of this show the same picture.
std::uint64_t FrameDigest(const core::RayFrame& frame);

}  // namespace tiles
