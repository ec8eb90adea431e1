#include "tools/oos/replay/replay_bus.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "bus/accounts/ledger.hpp"
#include "core/clock.hpp"
#include "tools/oos/attach/attach.hpp"
#include "tools/oos/replay/bus_replay.hpp"
#include "tools/oos/verb/verb.hpp"

namespace oos {
namespace {

constexpr std::int64_t kPoll_ns = 10'000'000;
// Time at the end for the last messages to arrive.
constexpr std::int64_t kDelivery_ns = 2 * core::kNanosecondsPerSecond;

// Reads lines of standard input as they arrive; the end of the input is no command.
class CommandLines {
 public:
  bool Next(std::string* line) {
    Read();
    const std::size_t end = text_.find('\n');
    if (end == std::string::npos) return false;
    *line = text_.substr(0, end);
    text_.erase(0, end + 1);
    return true;
  }

 private:
  void Read() {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    while (!is_closed_ && ::poll(&input, 1, 0) > 0) {
      char bytes[256];
      const ssize_t got = ::read(STDIN_FILENO, bytes, sizeof bytes);
      if (got <= 0) {
        is_closed_ = true;
      } else {
        text_.append(bytes, static_cast<std::size_t>(got));
      }
    }
  }
  std::string text_;
  bool is_closed_ = false;
};

void PrintState(const BusReplay& replay, const char* what) {
  std::printf("%s at %.3f of %.3f s, %llu messages\n", what, replay.position_s(), replay.duration_s(),
              static_cast<unsigned long long>(replay.num_published()));
  std::fflush(stdout);
}

// False if the command was quit.
core::Result<bool> Apply(const std::string& line, BusReplay* replay) {
  const auto command = ParseReplayCommand(line);
  const std::int64_t now_ns = core::MonotonicNow_ns();
  if (!command) {
    std::printf("'%s' is not pause, play, step [MESSAGES], seek SECONDS, speed X or quit\n", line.c_str());
    std::fflush(stdout);
    return true;
  }
  if (command->kind == ReplayCommand::Kind::kQuit) return false;
  if (command->kind == ReplayCommand::Kind::kSeek) {
    if (auto done = replay->Seek(command->value, now_ns); !done) return tl::unexpected(done.error());
  } else {
    replay->Apply(*command, now_ns);
  }
  if (auto done = replay->Advance(now_ns); !done) return tl::unexpected(done.error());
  PrintState(*replay, replay->is_paused() ? "paused" : "playing");
  return true;
}

core::Result<void> Play(double from_s, bool loops, bus::Node* node, BusReplay* replay) {
  const std::atomic<int>& interrupted = CatchInterrupt();
  CommandLines lines;
  std::string line;
  while (interrupted.load() == 0) {
    const std::int64_t now_ns = core::MonotonicNow_ns();
    node->Wait(std::min(replay->due_ns().value_or(now_ns + kPoll_ns), now_ns + kPoll_ns));
    while (lines.Next(&line)) {
      const auto goes_on = Apply(line, replay);
      if (!goes_on) return tl::unexpected(goes_on.error());
      if (!*goes_on) return {};
    }
    if (auto done = replay->Advance(core::MonotonicNow_ns()); !done) return done;
    if (!replay->is_over() || replay->is_paused()) continue;
    if (!loops) break;
    if (auto done = replay->Seek(from_s, core::MonotonicNow_ns()); !done) return done;
  }
  return {};
}

// Waits until slow readers have acknowledged their states and events, which would be lost with this process. Returns a
// text of the accounts that stay open.
std::string WaitForDelivery(bus::Node* node) {
  const std::int64_t end_ns = core::MonotonicNow_ns() + kDelivery_ns;
  std::string open;
  do {
    node->Wait(core::MonotonicNow_ns() + kPoll_ns);
    open.clear();
    for (const bus::Account& account : node->Accounts()) {
      if (account.is_writer && !account.is_settled()) open += (open.empty() ? "" : "; ") + bus::Describe(account);
    }
  } while (!open.empty() && core::MonotonicNow_ns() < end_ns);
  return open;
}

}  // namespace

int RunBusReplay(const Arguments& arguments) {
  const auto speed = arguments.number("--speed");
  const auto from_s = arguments.number("--from");
  if (!speed || (*speed && !(**speed > 0.0))) return Complain("replay", "--speed needs a number above 0", kBadUsage);
  if (!from_s || (*from_s && **from_s < 0.0)) return Complain("replay", "--from needs seconds, 0 or more", kBadUsage);
  auto replay = BusReplay::Open(arguments.positional()[0]);
  if (!replay) return Complain("replay", replay.error().detail, kBadUsage);
  auto options = FindSession(arguments);
  if (!options) return Complain("replay", options.error().detail, kDoesNotHold);
  options->name = "oos-replay-" + std::to_string(getpid());  // a name for which the tools' key is good
  auto node = bus::Node::Create(*options);
  if (!node) return Complain("replay", node.error().detail, kDoesNotHold);
  (*replay)->Declare(node->get());
  if (const auto started = (*node)->Start(5'000'000'000); !started) {
    return Complain("replay", started.error().detail, kDoesNotHold);
  }
  std::printf("%zu topics, %.3f s\n", (*replay)->topics().size(), (*replay)->duration_s());
  std::fflush(stdout);
  const std::int64_t now_ns = core::MonotonicNow_ns();
  if (*speed) (*replay)->Apply({ReplayCommand::Kind::kSpeed, **speed}, now_ns);
  if (arguments.has("--pause")) (*replay)->Apply({ReplayCommand::Kind::kPause}, now_ns);
  auto done = (*replay)->Seek(from_s->value_or(0.0), now_ns);
  if (done) done = Play(from_s->value_or(0.0), arguments.has("--loop"), node->get(), replay->get());
  if (!done) return Complain("replay", done.error().detail, kDoesNotHold);
  const std::string open = WaitForDelivery(node->get());
  PrintState(**replay, "ended");
  if ((*replay)->num_not_published() > 0) {
    return Complain("replay",
                    std::to_string((*replay)->num_not_published()) +
                        " messages were not published: the bus did not take them, or they cannot be read; see 'oos cat'"
                        " for what they are, or replay with a smaller --speed",
                    kDoesNotHold);
  }
  if (!open.empty()) return Complain("replay", "readers have not received everything: " + open, kDoesNotHold);
  return kHolds;
}

}  // namespace oos
