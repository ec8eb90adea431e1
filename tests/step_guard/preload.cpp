// Preloaded into a node: proves for the real process what step_guard.hpp counts. The step thread is the one that takes
// batches of datagrams (recvmmsg, only called by Node::Wait). After kWarmSteps batches it is armed; what it did counts
// when it takes the next batch, so what comes after the last step (the report) does not. At the end the counts are
// written to $STEP_GUARD_FOLDER/<process name>.txt, with the place of the first.

#include <fcntl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "bus/testing/step_guard.hpp"

namespace {

using bus::step_guard::Counts;

constexpr std::uint64_t kWarmSteps = 3000;

struct Total {
  std::uint64_t steps = 0;
  std::uint64_t dirty_steps = 0;
  Counts counts;
  std::array<void*, bus::step_guard::kMaxFrames> first{};
  int num_frames = 0;
} total;  // of the step thread

thread_local std::uint64_t num_batches [[gnu::tls_model("initial-exec")]] = 0;

void EndStep() {
  bus::step_guard::Thread& thread = bus::step_guard::thread_state;
  if (++num_batches < kWarmSteps) return;
  if (thread.is_armed) {
    ++total.steps;
    if (thread.counts.sum() != 0) ++total.dirty_steps;
    total.counts.allocations += thread.counts.allocations;
    total.counts.locks += thread.counts.locks;
    total.counts.logs += thread.counts.logs;
    if (total.num_frames == 0 && thread.num_frames != 0) {
      total.first = thread.first;
      total.num_frames = thread.num_frames;
    }
  }
  bus::step_guard::Arm();
}

struct Report {
  ~Report() {
    bus::step_guard::Disarm();
    const char* folder = std::getenv("STEP_GUARD_FOLDER");
    if (folder == nullptr || total.steps == 0) return;
    const std::string file = std::string(folder) + "/" + program_invocation_short_name + ".txt";
    const int fd = open(file.c_str(), O_CREAT | O_WRONLY | O_TRUNC | O_CLOEXEC, 0600);
    if (fd < 0) return;
    dprintf(fd, "%lu %lu %lu %lu %lu\n", total.steps, total.dirty_steps, total.counts.allocations, total.counts.locks,
            total.counts.logs);
    if (total.num_frames != 0) backtrace_symbols_fd(total.first.data(), total.num_frames, fd);
    close(fd);
  }
} report;

}  // namespace

extern "C" int recvmmsg(int socket, mmsghdr* headers, unsigned count, int flags, timespec* timeout) {
  EndStep();
  static const auto next = bus::step_guard::Next(&recvmmsg, "recvmmsg");
  return next(socket, headers, count, flags, timeout);
}
