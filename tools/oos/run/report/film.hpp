#pragma once

#include <atomic>
#include <filesystem>

#include "core/result.hpp"

namespace oos {

// Makes film.mp4 in a run's folder of what its viewer recorded: from the first step to the end in at most 20 s, by time
// lapse where the run is longer. Starts a display of its own where there is none. Errors: kNotFound, naming what is
// missing (the recording, ffmpeg, Xvfb); kIo, also when somebody interrupts it: `interrupted` is not 0.
core::Result<void> MakeFilm(const std::filesystem::path& folder, const std::atomic<int>* interrupted = nullptr);

}  // namespace oos
