#include "tests/support/step_watch.hpp"

#if !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)

#include <cstdlib>
#include <memory>

#include "bus/testing/step_guard.hpp"

namespace system_tests {
namespace {

// The calls that led to the first count, a line each.
std::string Backtrace(const bus::step_guard::Thread& thread) {
  const std::unique_ptr<char*, decltype(&std::free)> lines(backtrace_symbols(thread.first.data(), thread.num_frames),
                                                           &std::free);
  std::string text;
  for (int i = 0; i < thread.num_frames; ++i) text += std::string(lines.get()[i]) + "\n";
  return text;
}

}  // namespace

bool StepWatch::is_possible() {
  return true;
}

void StepWatch::Watch(lockstep::Options* options) {
  options->watch_steps = [this](std::string_view node, bool is_beginning) {
    if (is_beginning) {
      if (!steps_.contains(node)) steps_.emplace(node, Steps{});
      bus::step_guard::Arm();
    } else {
      bus::step_guard::Disarm();
      End(&steps_.find(node)->second);
    }
  };
}

void StepWatch::End(Steps* steps) {
  if (++steps->count <= kWarmSteps) return;
  const bus::step_guard::Thread& thread = bus::step_guard::thread_state;
  if (thread.counts.sum() == 0) return;
  ++steps->dirty;
  steps->allocations += thread.counts.allocations;
  steps->locks += thread.counts.locks;
  steps->logs += thread.counts.logs;
  if (steps->first.empty()) steps->first = Backtrace(thread);
}

}  // namespace system_tests

#else

namespace system_tests {

bool StepWatch::is_possible() {
  return false;
}
void StepWatch::Watch(lockstep::Options*) {}

}  // namespace system_tests

#endif

namespace system_tests {

const StepWatch::Steps& StepWatch::of(std::string_view node) const {
  static const Steps kNone;
  const auto found = steps_.find(node);
  return found == steps_.end() ? kNone : found->second;
}

}  // namespace system_tests
