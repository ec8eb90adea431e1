#include "tools/oos/run/report/film.hpp"

#include <algorithm>
#include <cstdlib>

#include "tools/oos/pictures/video.hpp"
#include "tools/oos/run/report/report_page.hpp"
#include "tools/oos/run/report/run_history.hpp"
#include "tools/oos/run/session/virtual_display.hpp"

namespace oos {
namespace {

constexpr double kLongest_s = 20.0;
constexpr double kFramesPerS = 20.0;  // enough for a time lapse, and two thirds of the work of 30

}  // namespace

core::Result<void> MakeFilm(const std::filesystem::path& folder, const std::atomic<int>* interrupted) {
  const std::filesystem::path recording = SceneRecording(folder);
  std::error_code error;
  if (!std::filesystem::exists(recording, error)) {
    return core::Fail(core::ErrorCode::kNotFound,
                      "no " + recording.string() + ": the film needs a run with visual_node, which leaves it");
  }
  if (!HasFfmpeg()) return core::Fail(core::ErrorCode::kNotFound, "ffmpeg is missing: apt-get install ffmpeg");
  const auto source = FindPictureSource(recording.string(), "");
  if (!source) return tl::unexpected(source.error());
  const RunHistory history = RunHistory::Read(folder);
  VideoOptions options;
  options.file = FilmFile(folder);
  options.frames_per_s = kFramesPerS;
  options.interrupted = interrupted;
  options.frames = {"--from", std::to_string(history.film_from_s), "--speed",
                    std::to_string(std::max(1.0, history.film_length_s / kLongest_s))};
  process::Group display;
  if (const char* given = std::getenv("DISPLAY"); given == nullptr || *given == '\0') {
    const auto started = StartVirtualDisplay(&display, folder / "Xvfb.log");
    if (!started) return tl::unexpected(started.error());
    options.environment["DISPLAY"] = *started;
  }
  return MakeVideo(*source, options);
}

}  // namespace oos
