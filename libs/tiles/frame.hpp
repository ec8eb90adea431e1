#pragma once

#include <cstdint>
#include <vector>

#include "core/messages/rays.hpp"
#include "core/result.hpp"
#include "tiles/quality.hpp"
#include "tiles/tile.hpp"
#include "view/appearance/environment_light.hpp"
#include "view/frustum.hpp"
#include "view/scene.hpp"

namespace tiles {

// A rectangle of a picture as an eye sees it. Two eyes, and several views in one window, are parts of one picture: all
// of them show the same moment, and whoever is free draws any of them.
struct SeenPart {
  view::Frustum eye;
  Tile at;
};

// Parts of these sizes [px], below each other.
std::vector<Tile> StackParts(const std::vector<glm::ivec2>& sizes_px);

// What of a scene its light and depths depend on, for a message. The picture is as large as its parts need. What is
// over the scene (arrows, captions) and far away (stars, Earth) is not in it.
core::RayFrame EncodeFrame(const view::Scene& scene, const view::EnvironmentLight& light,
                           const std::vector<SeenPart>& parts);
// A picture of one part. `placed` is in W.
core::RayFrame EncodeFrame(const view::Scene& scene, const view::EnvironmentLight& light, const scene::Camera& placed,
                           int width, int height);

// Puts a frame's things where it has them. `scene` has been made of the same scenario. False, and the scene is
// unchanged, when it has other things, so that the frame is of another scenario, or when the frame's parts are no
// rectangles of its picture with an eye.
bool ApplyFrame(const core::RayFrame& frame, view::Scene* scene);
view::EnvironmentLight LightOf(const core::RayFrame& frame);
Quality QualityOf(const core::RayFrame& frame);
std::vector<SeenPart> PartsOf(const core::RayFrame& frame);

// Frames with equal numbers of this show the same picture.
std::uint64_t FrameDigest(const core::RayFrame& frame);

}  // namespace tiles
