#include "tools/oos/run/session/virtual_display.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/clock.hpp"

namespace oos {
namespace {

constexpr std::int64_t kPatience_ns = 15 * core::kNanosecondsPerSecond;

std::filesystem::path FindXvfb() {
  for (const char* path : {"/usr/bin/Xvfb", "/usr/local/bin/Xvfb", "/usr/X11R6/bin/Xvfb"}) {
    if (access(path, X_OK) == 0) return path;
  }
  return {};
}

}  // namespace

core::Result<std::string> StartVirtualDisplay(process::Group* group, const std::filesystem::path& log,
                                              const std::vector<std::string>& options) {
  const std::filesystem::path program = FindXvfb();
  if (program.empty()) {
    return core::Fail(core::ErrorCode::kNotFound,
                      "no DISPLAY and no Xvfb: apt-get install xvfb, or leave the pictures out with "
                      "--without visual_node");
  }
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) {
    return core::Fail(core::ErrorCode::kResource, std::string("cannot open a pipe: ") + std::strerror(errno));
  }
  std::vector<std::string> arguments = {
      "-displayfd", std::to_string(ends[1]), "-screen", "0", "1280x720x24", "-nolisten", "tcp", "-noreset"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const auto pid = group->Spawn({"Xvfb", program, arguments, {}, log, 5, ends[1]});
  close(ends[1]);
  if (!pid) {
    close(ends[0]);
    return core::Fail(pid.error().code, pid.error().detail);
  }
  std::string number;
  const std::int64_t deadline = core::MonotonicNow_ns() + kPatience_ns;
  while (number.find('\n') == std::string::npos) {
    pollfd waiting{ends[0], POLLIN, 0};
    const std::int64_t left_ms = (deadline - core::MonotonicNow_ns()) / 1'000'000;
    char buffer[16];
    if (left_ms <= 0 || poll(&waiting, 1, static_cast<int>(left_ms)) <= 0) break;
    const ssize_t got = read(ends[0], buffer, sizeof buffer);
    if (got <= 0) break;  // it ended without a display number
    number.append(buffer, static_cast<std::size_t>(got));
  }
  close(ends[0]);
  if (number.find('\n') == std::string::npos) {
    return core::Fail(core::ErrorCode::kTimeout, "Xvfb did not start; its output is in " + log.string());
  }
  return ":" + number.substr(0, number.find('\n'));
}

}  // namespace oos
