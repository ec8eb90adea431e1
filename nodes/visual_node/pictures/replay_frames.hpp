#pragma once

#include <cstdio>
#include <functional>

#include "core/result.hpp"
#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/options.hpp"
#include "nodes/visual_node/structures.hpp"
#include "picture/image.hpp"
#include "scene/scenario.hpp"
#include "view/recorded_scene.hpp"

namespace visual_node {

using FrameSink = std::function<core::Result<void>(const picture::Image&)>;

// Renders a recording frame by frame at recorded times, however long a frame takes: frame k is the picture of
//   t = from + speed k / fps,
// the same that RenderShot makes of that time. Errors: as RenderShot's, and the sink's.
core::Result<void> RenderFrames(const Options& options, const scene::Scenario& scenario, const FrameSink& sink);
// The same of an open recording with a given renderer.
core::Result<void> DrawFrames(const Options& options, view::RecordedScene* recording, Renderer* renderer,
                              StructureShow* structures, const FrameSink& sink);

// A frame as a binary PPM picture. Error: kIo, when the reader is gone.
core::Result<void> WritePpm(const picture::Image& image, std::FILE* file);

}  // namespace visual_node
