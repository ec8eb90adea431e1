#pragma once

#include <atomic>
#include <filesystem>

#include "core/result.hpp"
#include "scene/scenario.hpp"
#include "tools/web_bridge/scene_stream/commands.hpp"
#include "tools/web_bridge/scene_stream/stream.hpp"

namespace scene_stream {

// Streams a recording as the commands want it, paused at its begin, until it is stopped. Errors: those of
// view::RecordedScene; the reader has gone.
core::Result<void> StreamRecording(const std::filesystem::path& file, const scene::Scenario& scenario, Stream* stream,
                                   CommandLines* commands, const std::atomic<int>& interrupted);

}  // namespace scene_stream
