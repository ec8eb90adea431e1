#pragma once

#include <atomic>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "tools/oos/pictures/picture_source.hpp"
#include "tools/process/spawn.hpp"

namespace oos {

struct VideoOptions {
  std::filesystem::path file;       // its ending chooses the container: .mp4, .mkv, .mov
  std::vector<std::string> frames;  // further options of `visual_node --frames`
  double frames_per_s = 30.0;
  std::map<std::string, std::string> environment;  // of visual_node, beside the caller's own
  int nice = 0;
  const std::atomic<int>* interrupted = nullptr;  // not 0: stop, and leave no part of a film
};

// Renders a recording frame by frame and encodes it (H.264 by ffmpeg). Errors: kNotFound, when ffmpeg is missing;
// kInvalidInput, when visual_node refuses its options; kIo, also when interrupted.
core::Result<void> MakeVideo(const PictureSource& source, const VideoOptions& options);

// ffmpeg, which makes that film of PPM pictures that it reads from `input`: "-" is its stdin, "pipe:7" an open file.
// The file's ending chooses the container.
process::Command FilmEncoder(const std::string& input, const std::filesystem::path& file, double frames_per_s);

// Whether ffmpeg is in PATH.
bool HasFfmpeg();

}  // namespace oos
