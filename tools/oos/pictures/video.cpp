#include "tools/oos/pictures/video.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <ctime>
#include <sstream>

#include "tools/oos/attach/places.hpp"
#include "tools/oos/verb/verb.hpp"
#include "tools/process/spawn.hpp"

namespace oos {
namespace {

process::Command Painter(const PictureSource& source, const VideoOptions& options) {
  process::Command command;
  command.name = "visual_node";
  command.program = ProgramFolder() / "visual_node";
  command.environment = options.environment;
  command.nice = options.nice;
  command.arguments = {"--scenario",
                       source.scenario.string(),
                       "--recording",
                       source.recording.string(),
                       "--frames",
                       "--fps",
                       std::to_string(options.frames_per_s)};
  command.arguments.insert(command.arguments.end(), options.frames.begin(), options.frames.end());
  return command;
}

constexpr long kPoll_ns = 50'000'000;

// Until the child has ended, which it is told to do when somebody interrupts.
process::Exit WaitFor(pid_t child, const std::atomic<int>* interrupted) {
  const timespec pause{0, kPoll_ns};
  siginfo_t ended{};
  while (interrupted != nullptr && waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         ended.si_pid == 0) {
    if (interrupted->load() != 0) {
      kill(child, SIGTERM);
      break;
    }
    nanosleep(&pause, nullptr);
  }
  return process::Wait(child);
}

}  // namespace

// H.264 in 4:2:0, which every browser and player shows; that needs even sizes, so an odd one gets a black line. Without
// ffmpeg's version in the file the same frames give the same bytes.
process::Command FilmEncoder(const std::string& input, const std::filesystem::path& file, double frames_per_s) {
  process::Command command;
  command.name = "ffmpeg";
  command.program = "ffmpeg";
  command.arguments = {"-loglevel",
                       "error",
                       "-y",
                       "-f",
                       "image2pipe",
                       "-c:v",
                       "ppm",
                       "-framerate",
                       std::to_string(frames_per_s),
                       "-i",
                       input,
                       "-vf",
                       "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                       "-c:v",
                       "libx264",
                       "-preset",
                       "veryfast",
                       "-crf",
                       "20",
                       "-pix_fmt",
                       "yuv420p",
                       "-fflags",
                       "+bitexact",
                       "-flags:v",
                       "+bitexact",
                       "-movflags",
                       "+faststart",
                       file.string()};
  return command;
}

bool HasFfmpeg() {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (access((folder + "/ffmpeg").c_str(), X_OK) == 0) return true;
  }
  return false;
}

core::Result<void> MakeVideo(const PictureSource& source, const VideoOptions& options) {
  if (!HasFfmpeg()) return core::Fail(core::ErrorCode::kNotFound, "ffmpeg is missing: apt-get install ffmpeg");
  std::error_code error;
  if (options.file.has_parent_path()) std::filesystem::create_directories(options.file.parent_path(), error);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return core::Fail(core::ErrorCode::kResource, "cannot open a pipe");
  process::Command film = FilmEncoder("-", options.file, options.frames_per_s);
  film.nice = options.nice;
  const auto encoder = process::Spawn(film, {.in_fd = ends[0], .group = process::Bond::Group::kCallers});
  close(ends[0]);
  if (!encoder) {
    close(ends[1]);
    return tl::unexpected(encoder.error());
  }
  const auto painter =
      process::Spawn(Painter(source, options), {.out_fd = ends[1], .group = process::Bond::Group::kCallers});
  close(ends[1]);
  const process::Exit painted = painter ? WaitFor(*painter, options.interrupted) : process::Exit{.status = 1};
  const process::Exit encoded = process::Wait(*encoder);
  if (!painter) return tl::unexpected(painter.error());
  if (options.interrupted != nullptr && options.interrupted->load() != 0) {
    std::filesystem::remove(options.file, error);
    return core::Fail(core::ErrorCode::kIo, "no video: interrupted");
  }
  const bool is_encoder_at_fault = painted.signal == SIGPIPE || (painted.is_clean() && !encoded.is_clean());
  if (is_encoder_at_fault) {
    return core::Fail(core::ErrorCode::kIo,
                      "ffmpeg could not make " + options.file.string() + " (" + encoded.Describe() + ")");
  }
  if (painted.is_clean()) return {};
  std::filesystem::remove(options.file, error);  // what ffmpeg made of nothing, or of a part
  const bool is_input_bad = painted.signal == 0 && painted.status == kBadUsage;
  return core::Fail(is_input_bad ? core::ErrorCode::kInvalidInput : core::ErrorCode::kIo,
                    "no video: visual_node ended with " + painted.Describe());
}

}  // namespace oos
