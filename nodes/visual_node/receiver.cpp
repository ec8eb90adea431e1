#include "nodes/visual_node/receiver.hpp"

#include <sys/resource.h>

#include <cstdio>
#include <utility>

#include "core/clock.hpp"
#include "view/scene_digest.hpp"

namespace visual_node {
namespace {

// Chosen, not measured: the first bounds the time to stop, the second is fast enough for a display, and the third is
// half of a frame at 60 Hz.
constexpr std::int64_t kWait_ns = 10'000'000;
constexpr std::int64_t kHandPeriod_ns = 50'000'000;         // well below what device_bridge takes for silence
constexpr std::int64_t kSlowestDrawing_ns = 2'000'000'000;  // a drawing thread that takes longer has stopped
constexpr std::int64_t kWallWait_ns = 1'000'000;            // what walls have to say to each other waits no longer
constexpr std::int64_t kFiguresPeriod_ns = 250'000'000;
constexpr std::int64_t kQuietPublish_ns = 8'000'000;  // publishes changes that come without a physics state

constexpr std::int64_t kHeadAge_ns = 200'000'000;  // as the topic's; an older one is not known any more
constexpr const char* kEyeDistanceName = "eye_distance_mm";

}  // namespace

core::Result<void> Receiver::Record(const std::filesystem::path& file) {
  auto recorder = view::SceneRecorder::Create(file, scenario_);
  if (!recorder) return tl::unexpected(recorder.error());
  recorder_ = std::move(*recorder);
  return {};
}

core::Result<void> Receiver::Begin(const bus::NodeOptions& options) {
  auto node = bus::Node::Create(options);
  if (!node) return tl::unexpected(node.error());
  node_ = std::move(*node);
  feed_.emplace(scenario_, node_.get());
  figures_ = node_->WriteState<bus::Figures>(bus::FiguresTopic(options.name));
  if (steers_) hand_writer_ = node_->WriteLatest<core::HandInput>(bus::HandInputTopic(options.name));
  node_->ReadEvents();
  const view::Assets& assets = *mirror_.scene().assets;
  std::vector<std::string> parameters = view::ChoiceNames(assets.instance_names);
  for (const scene::Camera& camera : assets.cameras) {
    parameters.push_back(CameraFeed::RateName(camera.name));
    cameras_.push_back(node_->WriteState<core::CameraImage>(bus::CameraImageTopic(options.name, camera.name)));
  }
  parameters.emplace_back(kEyeDistanceName);
  if (!user_.empty()) head_reader_ = &node_->ReadLatest<core::HeadState>(bus::HeadTopic(user_));
  if (walls_ != nullptr) {
    walls_->Declare(node_.get());
    kept_ = std::make_unique<KeptScenes>();
  }
  image_rates_hz_.resize(assets.cameras.size());
  node_->OwnParameters(std::move(parameters));
  newest_.Write(mirror_.scene());
  return node_->Start(0);
}

core::Result<void> Receiver::Join() {
  if (auto joined = node_->Start(); !joined) return joined;
  thread_ = std::thread([this] { Run(); });
  return {};
}

void Receiver::Stop() {
  is_stopping_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
  if (recorder_ == nullptr) return;
  if (const auto closed = recorder_->Close(core::MonotonicNow_ns()); !closed) {
    std::fprintf(stderr, "the scene's recording is not whole: %s\n", closed.error().detail.c_str());
  }
  recorder_.reset();
}

void Receiver::Leave() {
  Stop();
  feed_.reset();
  node_.reset();
}

// A full disk ends the recording, not the viewer.
void Receiver::RecordScene(std::int64_t now_ns) {
  if (recorder_ == nullptr) return;
  if (const auto taken = recorder_->Take(*feed_, now_ns); !taken) {
    std::fprintf(stderr, "the scene's recording ends here: %s\n", taken.error().detail.c_str());
    recorder_.reset();
  }
}

std::vector<std::string> Receiver::TakeScreenshotRequests() {
  const std::scoped_lock lock(requests_mutex_);
  return std::exchange(requests_, {});
}

view::Choices Receiver::choices() const {
  const std::scoped_lock lock(choices_mutex_);
  return choices_;
}

std::vector<double> Receiver::image_rates_hz() const {
  const std::scoped_lock lock(choices_mutex_);
  return image_rates_hz_;
}

void Receiver::SendImage(CameraFeed::Seen seen) {
  const std::scoped_lock lock(choices_mutex_);
  images_.push_back(std::move(seen));
}

void Receiver::TakeHead() {
  if (head_reader_ == nullptr || !head_reader_->is_fresh()) return;
  const std::scoped_lock lock(head_mutex_);
  head_ = head_reader_->value();
  head_received_ns_ = head_reader_->received_ns();
}

view::Head Receiver::head() const {
  if (user_.empty()) return {};
  const std::scoped_lock lock(head_mutex_);
  const bool is_known = head_received_ns_ != 0 && core::MonotonicNow_ns() - head_received_ns_ < kHeadAge_ns;
  if (!is_known) return {{}, view::HeadSource::kMissing};
  return {head_.X_RH, head_.is_simulated ? view::HeadSource::kSimulated : view::HeadSource::kTracked};
}

void Receiver::SendImages() {
  std::vector<CameraFeed::Seen> images;
  {
    const std::scoped_lock lock(choices_mutex_);
    images.swap(images_);
  }
  for (const CameraFeed::Seen& seen : images) cameras_[seen.camera].Set(seen.image);
}

bool Receiver::TakeChange(const core::ParameterChange& change, std::string* why) {
  const view::Assets& assets = *mirror_.scene().assets;
  const std::scoped_lock lock(choices_mutex_);
  for (std::size_t i = 0; i < assets.cameras.size(); ++i) {
    if (change.name != CameraFeed::RateName(assets.cameras[i].name)) continue;
    *why = "from 0 to 5 pictures a second";
    if (!(change.value >= 0.0 && change.value <= CameraFeed::kMostPerSecond)) return false;
    image_rates_hz_[i] = change.value;
    return true;
  }
  if (change.name == kEyeDistanceName) {
    *why = "from 0 to 200 mm";
    if (!(change.value >= 0.0 && change.value <= 1e3 * view::kMostEyeDistance_m)) return false;
    choices_.eye_distance_m = 1e-3 * change.value;
    return true;
  }
  *why = "1 shows it, 0 does not";
  if (change.value != 0.0 && change.value != 1.0) return false;
  return view::SetChoice(change.name, change.value == 1.0, assets.instance_names, &choices_);
}

void Receiver::TakeParameters() {
  core::ParameterChange change;
  std::uint64_t ticket = 0;
  while (node_->PollParameter(&change, &ticket)) {
    std::string why;
    const bool is_taken = TakeChange(change, &why);
    node_->AckParameter(ticket, num_states(), is_taken, is_taken ? "" : why);
  }
}

// At the drawing's rate; while a picture takes long, the newest again and again, so that a slow viewer does not count
// as one that has let go.
void Receiver::SendHands(std::int64_t now_ns) {
  const bool is_new = hand_.Update();
  if (is_new) hand_changed_ns_ = now_ns;
  const bool is_repeated = now_ns - hand_changed_ns_ < kSlowestDrawing_ns && now_ns - hand_sent_ns_ > kHandPeriod_ns;
  if (!is_new && !is_repeated) return;
  hand_sent_ns_ = now_ns;
  core::HandInput input = hand_.value();
  hand_writer_.Send(input);
}

void Receiver::Run() {
  // The process has a low priority because of its drawing. This thread does little and should not wait for the drawing,
  // so it raises its priority where it may.
  setpriority(PRIO_PROCESS, 0, 0);
  while (!is_stopping_.load(std::memory_order_acquire)) {
    node_->Wait(core::MonotonicNow_ns() + (walls_ != nullptr ? kWallWait_ns : kWait_ns));
    const std::int64_t now_ns = core::MonotonicNow_ns();
    if (walls_ != nullptr) PumpWalls(now_ns);
    TakeHead();
    const bool is_state_fresh = ApplyAll(now_ns);
    TakeParameters();
    SendImages();
    if (steers_) SendHands(now_ns);
    if (is_state_fresh || now_ns >= next_publish_ns_) Publish(now_ns);
    if (is_state_fresh) {
      num_states_.fetch_add(1, std::memory_order_relaxed);
      log_->AddState(direct_, through_physics_);
    }
    RecordScene(now_ns);
    if (now_ns >= next_figures_ns_) PublishFigures(now_ns);
  }
}

// What the first wall has named is kept from the moment on that it is heard, because the drawing may come much later.
void Receiver::PumpWalls(std::int64_t now_ns) {
  walls_->Pump(node_.get(), kept_->ticks(), now_ns);
  kept_->Pin(walls_->named_tick());
}

// Applies all received messages. True when a physics state was among them.
bool Receiver::ApplyAll(std::int64_t now_ns) {
  const bool is_state_fresh = feed_->Apply(now_ns, &mirror_);
  core::Event event;
  while (node_->PollEvent(&event)) {
    if (event.name != "screenshot") continue;
    const std::scoped_lock lock(requests_mutex_);
    requests_.push_back(event.detail);
  }
  if (!is_state_fresh) return false;
  const auto& physics = feed_->physics();
  direct_ = physics.value().header.direct;
  through_physics_ = physics.value().header.through_physics;
  for (core::Trace* trace : {&direct_, &through_physics_})
    trace->Add(core::Stage::kVisualReceive, physics.received_ns());
  return true;
}

void Receiver::Publish(std::int64_t now_ns) {
  mirror_.Choose(choices());
  mirror_.Refresh(now_ns);
  view::Scene& slot = newest_.BeginWrite();
  slot = mirror_.scene();  // reuses the slot's buffers
  const std::int64_t applied_ns = core::MonotonicNow_ns();
  for (core::Trace* trace : {&direct_, &through_physics_}) {
    const bool is_stamped = !trace->stamps.empty() && trace->stamps.back().stage == core::Stage::kVisualApply;
    if (!is_stamped) trace->Add(core::Stage::kVisualApply, applied_ns);
  }
  slot.direct = direct_;
  slot.through_physics = through_physics_;
  if (walls_ != nullptr && feed_->physics().has_value()) kept_->Keep(feed_->physics().value().tick, slot);
  newest_.EndWrite();
  next_publish_ns_ = now_ns + kQuietPublish_ns;
}

void Receiver::PublishFigures(std::int64_t now_ns) {
  next_figures_ns_ = now_ns + kFiguresPeriod_ns;
  if (is_ready_.load(std::memory_order_acquire) && !is_ready_announced_) {
    core::Event event;
    event.time_ns = now_ns;
    event.source = node_->name();
    event.name = "ready";
    is_ready_announced_ = node_->Emit(event);
  }
  view::LiveFigures live;
  live.frames_per_s = frames_per_s_.load(std::memory_order_relaxed);
  live.render_scale = render_scale_.load(std::memory_order_relaxed);
  live.t2_state_ms = log_->recent_state_ms();
  live.t2_image_ms = log_->recent_image_ms();
  live.dropped = node_->counters().dropped;
  mirror_.Apply(live);
  bus::Figures figures;
  figures.items = {{"frames_per_s", live.frames_per_s},
                   {"render_scale", live.render_scale},
                   {"frames", static_cast<double>(frames_.load(std::memory_order_relaxed))},
                   {"t2_state_ms", live.t2_state_ms},
                   {"t2_image_ms", live.t2_image_ms},
                   {"dropped", static_cast<double>(live.dropped)},
                   {"walls_in_step", walls_in_step_.load(std::memory_order_relaxed)},
                   {"walls_apart_ms", walls_apart_ms_.load(std::memory_order_relaxed)},
                   {view::kSceneDigestFigure, static_cast<double>(view::SceneDigest(mirror_.scene()))}};
  figures_.Set(figures);
}

}  // namespace visual_node
