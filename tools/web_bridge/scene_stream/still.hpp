#pragma once

#include <atomic>

#include "core/result.hpp"
#include "scene/scenario.hpp"
#include "tools/web_bridge/scene_stream/commands.hpp"
#include "tools/web_bridge/scene_stream/stream.hpp"

namespace scene_stream {

// Streams a scenario as it begins, until it is stopped. Errors: those of Stream.
core::Result<void> StreamStill(const scene::Scenario& scenario, Stream* stream, CommandLines* commands,
                               const std::atomic<int>& interrupted);

}  // namespace scene_stream
