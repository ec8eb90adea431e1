#include "tools/web_bridge/scene_stream/recording.hpp"

#include <algorithm>
#include <ctime>

#include "core/clock.hpp"
#include "view/recorded_scene.hpp"

namespace scene_stream {
namespace {

constexpr timespec kPauseOfPlaying{0, 4'000'000};

struct Playing {
  double at_s = 0.0;
  double speed = 1.0;
  bool is_playing = false;
  view::Choices choices;
};

// True when something is to be shown anew.
bool Apply(const std::vector<Command>& commands, const std::vector<std::string>& objects, double duration_s,
           Stream* stream, Playing* playing) {
  using Kind = Command::Kind;
  for (const Command& command : commands) {
    switch (command.kind) {
      case Kind::kSet:
        view::SetChoice(command.name, command.value != 0.0, objects, &playing->choices);
        break;
      case Kind::kRate:
        stream->SetRate(command.value);
        break;
      case Kind::kPlay:
        playing->is_playing = true;
        if (playing->at_s >= duration_s) playing->at_s = 0.0;
        break;
      case Kind::kPause:
        playing->is_playing = false;
        break;
      case Kind::kSeek:
        playing->at_s = std::min(command.value, duration_s);
        break;
      case Kind::kSpeed:
        playing->speed = command.value;
        break;
      case Kind::kHand:
        break;  // a recording has no hand to steer
    }
  }
  return !commands.empty();
}

}  // namespace

core::Result<void> StreamRecording(const std::filesystem::path& file, const scene::Scenario& scenario, Stream* stream,
                                   CommandLines* commands, const std::atomic<int>& interrupted) {
  auto opened = view::RecordedScene::Open(file, scenario);
  if (!opened) return tl::unexpected(opened.error());
  view::RecordedScene& recorded = **opened;
  Playing playing;
  if (auto gone = recorded.GoTo(0.0); !gone) return gone;
  if (auto begun = stream->Begin(recorded.scene(), recorded.duration_s()); !begun) return begun;
  std::int64_t last_ns = core::MonotonicNow_ns();
  bool is_changed = true;
  while (interrupted.load() == 0) {
    const std::int64_t now_ns = core::MonotonicNow_ns();
    if (Apply(commands->Take(), recorded.scene().assets->instance_names, recorded.duration_s(), stream, &playing)) {
      is_changed = true;
    }
    if (playing.is_playing) {
      playing.at_s += playing.speed * 1e-9 * static_cast<double>(now_ns - last_ns);
      is_changed = true;
      if (playing.at_s >= recorded.duration_s()) {
        playing.at_s = recorded.duration_s();
        playing.is_playing = false;
      }
    }
    last_ns = now_ns;
    if (stream->IsDue(now_ns - (is_changed ? 0 : kPeriodOfStills_ns))) {
      is_changed = false;
      recorded.Choose(playing.choices);
      if (auto gone = recorded.GoTo(playing.at_s); !gone) return gone;
      auto sent = stream->Send(recorded.scene(), playing.choices, {playing.at_s, playing.is_playing, 0.0}, now_ns);
      if (!sent) return sent;
    }
    nanosleep(&kPauseOfPlaying, nullptr);
  }
  return {};
}

}  // namespace scene_stream
