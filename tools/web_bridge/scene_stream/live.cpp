#include "tools/web_bridge/scene_stream/live.hpp"

#include "core/clock.hpp"
#include "view/scene_digest.hpp"
#include "view/steering_caption.hpp"

namespace scene_stream {
namespace {

constexpr std::int64_t kWait_ns = 10'000'000;
constexpr std::int64_t kFiguresPeriod_ns = 250'000'000;
constexpr const char* kSteersAs = "client-page";       // device_bridge's --viewers
constexpr std::int64_t kQuietPeriod_ns = 100'000'000;  // between frames while no physics state comes

}  // namespace

// A topic has one writer: of several bridges of a session, the pages of the first steer.
core::Result<void> Live::Join(const bus::NodeOptions& options, bool steers) {
  feed_.reset();
  auto node = bus::Node::Create(options);
  if (!node) return tl::unexpected(node.error());
  node_ = std::move(*node);
  feed_.emplace(scenario_, node_.get());
  figures_ = node_->WriteState<bus::Figures>(bus::FiguresTopic(options.name));
  steers_ = steers;
  if (steers) hand_writer_ = node_->WriteLatest<core::HandInput>(bus::HandInputTopic(kSteersAs));
  node_->OwnParameters(view::ChoiceNames(mirror_.scene().assets->instance_names));
  return node_->Start();
}

core::Result<void> Live::Run(const bus::NodeOptions& options, const std::atomic<int>& interrupted) {
  auto joined = Join(options, true);
  const bool is_hand_taken = !joined && joined.error().detail.find(bus::HandInputTopic(kSteersAs)) != std::string::npos;
  if (is_hand_taken) joined = Join(options, false);
  if (!joined) return joined;
  mirror_.Refresh(core::MonotonicNow_ns());
  if (auto begun = stream_->Begin(mirror_.scene(), 0.0); !begun) return begun;
  bool is_ready = false;
  while (interrupted.load() == 0) {
    if (auto done = Step(); !done) return done;
    // As other viewers with their first picture.
    is_ready = is_ready || node_->Emit({core::MonotonicNow_ns(), node_->name(), "ready", ""});
  }
  return {};
}

core::Result<void> Live::Step() {
  node_->Wait(core::MonotonicNow_ns() + kWait_ns);
  const std::int64_t now_ns = core::MonotonicNow_ns();
  if (feed_->Apply(now_ns, &mirror_)) {
    ++num_states_;
    is_changed_ = true;
  }
  mirror_.Remember(now_ns);
  TakeCommands();
  TakeParameters();
  if (now_ns >= next_figures_ns_) PublishFigures(now_ns);
  if (!stream_->IsDue(now_ns - (is_changed_ ? 0 : kQuietPeriod_ns))) return {};
  is_changed_ = false;
  mirror_.Choose(choices_);
  mirror_.Refresh(now_ns);
  Stream::Moment moment;
  if (num_states_ > 0) moment.state_age_ms = 1e-6 * static_cast<double>(now_ns - feed_->physics().received_ns());
  if (!steers_ || mirror_.scene().guides.empty()) return stream_->Send(mirror_.scene(), choices_, moment, now_ns);
  view::Scene shown = mirror_.scene();
  view::DescribeSteering(scenario_, {.input = steering_.input(), .shows_next = shows_next_}, hand_camera_, &shown);
  return stream_->Send(shown, choices_, moment, now_ns);
}

void Live::TakeCommands() {
  for (const Command& command : commands_->Take()) {
    is_changed_ = true;
    if (command.kind == Command::Kind::kRate) stream_->SetRate(command.value);
    if (command.kind == Command::Kind::kHand) TakeHand(*command.hand);
    if (command.kind != Command::Kind::kSet) continue;
    view::SetChoice(command.name, command.value != 0.0, mirror_.scene().assets->instance_names, &choices_);
  }
}

// Of a session that a person steers; else nobody reads it.
void Live::TakeHand(const Command::Hand& hand) {
  const view::Scene& scene = mirror_.scene();
  if (!steers_ || hand.role >= scenario_.devices.size() || scene.guides.empty()) return;
  const int palm = scenario_.devices[hand.role].palm;
  const glm::dvec3 p_WD =
      palm >= 0 ? scene.instances[static_cast<std::size_t>(palm)].X_WM.translation : hand.camera.target_m;
  steering_.Choose(hand.role);
  shows_next_ = hand.shows_next;
  hand_camera_ = hand.camera;
  core::HandInput input = steering_.Update(hand.wish, hand.camera, hand.height_px, p_WD, hand.dt_s);
  hand_writer_.Send(input);
}

void Live::TakeParameters() {
  core::ParameterChange change;
  std::uint64_t ticket = 0;
  while (node_->PollParameter(&change, &ticket)) {
    const bool is_good =
        (change.value == 0.0 || change.value == 1.0) &&
        view::SetChoice(change.name, change.value == 1.0, mirror_.scene().assets->instance_names, &choices_);
    node_->AckParameter(ticket, num_states_, is_good, is_good ? "" : "1 shows it, 0 does not");
    is_changed_ = true;
  }
}

void Live::PublishFigures(std::int64_t now_ns) {
  next_figures_ns_ = now_ns + kFiguresPeriod_ns;
  bus::Figures figures;
  figures.items = {{view::kSceneDigestFigure, static_cast<double>(view::SceneDigest(mirror_.scene()))},
                   {"dropped", static_cast<double>(node_->counters().dropped)}};
  figures_.Set(figures);
}

}  // namespace scene_stream
