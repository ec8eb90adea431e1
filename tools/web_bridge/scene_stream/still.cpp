#include "tools/web_bridge/scene_stream/still.hpp"

#include <ctime>

#include "core/clock.hpp"
#include "view/scene_mirror.hpp"

namespace scene_stream {
namespace {

constexpr timespec kPauseOfStill{0, 10'000'000};

}  // namespace

core::Result<void> StreamStill(const scene::Scenario& scenario, Stream* stream, CommandLines* commands,
                               const std::atomic<int>& interrupted) {
  view::SceneMirror mirror(scenario);
  mirror.Refresh(0);
  view::Choices choices;
  const std::vector<std::string>& objects = mirror.scene().assets->instance_names;
  if (auto begun = stream->Begin(mirror.scene(), 0.0); !begun) return begun;
  while (interrupted.load() == 0) {
    bool is_changed = false;
    for (const Command& command : commands->Take()) {
      if (command.kind != Command::Kind::kSet) continue;
      is_changed = view::SetChoice(command.name, command.value != 0.0, objects, &choices) || is_changed;
    }
    const std::int64_t now_ns = core::MonotonicNow_ns();
    if (stream->IsDue(now_ns - (is_changed ? 0 : kPeriodOfStills_ns))) {
      mirror.Choose(choices);
      mirror.Refresh(0);
      if (auto sent = stream->Send(mirror.scene(), choices, {}, now_ns); !sent) return sent;
    }
    nanosleep(&kPauseOfStill, nullptr);
  }
  return {};
}

}  // namespace scene_stream
