#pragma once

#include <filesystem>
#include <string>

#include "bus/log/node_recording.hpp"
#include "bus/node.hpp"
#include "cli/arguments.hpp"
#include "core/result.hpp"

namespace visual_node {

struct Options {
  std::filesystem::path scenario;
  bus::NodeOptions node;  // a second viewer of the session has another name, "visual_node-2"
  std::filesystem::path out = ".";
  bus::log::RecordingOptions recording;
  int width = 640;  // of pictures that are kept, and of what is drawn without a window
  int height = 360;
  int window_width = 1280;
  int window_height = 720;
  std::string view;  // camera to stay with; empty: the camera named after the step, else the first
  bool is_headless = false;
  double max_frames_per_s = 30.0;
  bool is_still = false;  // --still: each named camera once, without any bus
};

cli::Syntax CommandLineSyntax();

// From a command line of that syntax. Errors: kInvalidInput, when options that belong together are not all there.
core::Result<Options> ReadOptions(const cli::Arguments& arguments);

}  // namespace visual_node
