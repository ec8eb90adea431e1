#include "nodes/rt_visual_node/exchange.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/clock.hpp"
#include "tiles/frame.hpp"

namespace rt_visual_node {
namespace {

// Answers are reliable and do not wake the thread. While tiles are under way they are looked for so often; their lists
// hold more work than that.
constexpr std::int64_t kWait_ns = 500'000, kIdleWait_ns = 2'000'000;
// A list of jobs goes as a datagram, which may be lost.
constexpr std::int64_t kRepeat_ns = 10'000'000;

double Seconds(std::int64_t time_ns) {
  return 1e-9 * static_cast<double>(time_ns);
}

}  // namespace

core::Result<void> Exchange::Start() {
  const std::string viewer = options_.name;
  bus::NodeOptions options = options_;
  options.name = viewer + "-tiles";
  auto node = bus::Node::Create(options);
  if (!node) return tl::unexpected(node.error());
  node_ = std::move(*node);
  frames_out_ = node_->WriteState<core::RayFrame>(bus::RayFrameTopic(viewer));
  for (std::size_t i = 0; i < seats_.size(); ++i) {
    const std::string seat = std::to_string(i + 1);
    seats_[i].worker = tiles::WorkerName(viewer, i + 1);
    seats_[i].jobs = node_->WriteLatest<core::RayJobs>(bus::RayJobsTopic(viewer, seat));
    seats_[i].tiles = &node_->ReadState<core::RayTile>(bus::RayTileTopic(viewer, seat));
  }
  // Workers may have known an earlier life of this viewer.
  const auto now = static_cast<std::uint64_t>(core::MonotonicNow_ns());
  schedule_ = std::make_unique<tiles::Schedule>(seats_.size(), now);
  next_frame_ = now;
  if (auto begun = node_->Start(0); !begun) return begun;
  thread_ = std::thread([this] {
    const auto joined = node_->Start();
    if (!joined) trouble_ = joined.error().detail;
    if (joined) Run();
  });
  return {};
}

void Exchange::Stop() {
  is_stopping_.store(true);
  if (thread_.joinable()) thread_.join();
}

void Exchange::Want(Wish wish) {
  const std::scoped_lock lock(mutex_);
  wish_ = std::move(wish);
}

std::unique_ptr<Drawn> Exchange::Take(std::int64_t deadline_ns) {
  std::unique_lock lock(mutex_);
  const std::int64_t left_ns = deadline_ns - core::MonotonicNow_ns();
  if (left_ns > 0) is_done_.wait_for(lock, std::chrono::nanoseconds(left_ns), [this] { return done_ != nullptr; });
  return std::move(done_);
}

Exchange::Figures Exchange::figures() const {
  const std::scoped_lock lock(mutex_);
  return figures_;
}

void Exchange::Run() {
  while (!is_stopping_.load(std::memory_order_relaxed)) {
    node_->Wait(core::MonotonicNow_ns() + (in_flight_.empty() ? kIdleWait_ns : kWait_ns));
    TakeEvents();
    TakeTiles();
    schedule_->Update(Seconds(core::MonotonicNow_ns()));
    while (const auto frame = schedule_->TakeDone()) Finish(*frame);
    BeginFrames();
    SendJobs();
  }
}

// A worker is on its seat from its first message on, until it leaves the bus.
void Exchange::TakeEvents() {
  core::Event event;
  while (node_->PollEvent(&event)) {
    if (event.name == "node_found") alive_.insert(event.detail);
    if (event.name == "node_lost" || event.name == "node_left") alive_.erase(event.detail);
  }
  std::size_t workers = 0;
  for (std::size_t i = 0; i < seats_.size(); ++i) {
    const bool is_there = alive_.count(seats_[i].worker) != 0 && seats_[i].tiles->has_value();
    if (is_there && !schedule_->IsTaken(i)) schedule_->Join(i, Seconds(core::MonotonicNow_ns()));
    if (!is_there && schedule_->IsTaken(i)) schedule_->Leave(i);
    if (is_there) ++workers;
  }
  num_workers_.store(workers, std::memory_order_relaxed);
}

void Exchange::TakeTiles() {
  for (std::size_t i = 0; i < seats_.size(); ++i) {
    if (!seats_[i].tiles->is_fresh()) continue;
    for (const auto& [key, tile] : seats_[i].tiles->values()) {
      if (std::exchange(seats_[i].seen[key], tile.job) != tile.job) TakeTile(i, tile);
    }
  }
}

void Exchange::TakeTile(std::size_t seat, const core::RayTile& tile) {
  const double cost_s = 1e-9 * static_cast<double>(tile.cost_ns);
  const auto answer = schedule_->Take(seat, tile.job, cost_s, Seconds(core::MonotonicNow_ns()));
  if (!answer) return;
  Drawn& drawn = *in_flight_.at(answer->frame);
  drawn.cost_s += cost_s;
  // A worker of another version draws nothing there.
  if (!tiles::DecodePixels(tile.pixels, answer->tile, &drawn.canvas)) return;
  const std::scoped_lock lock(mutex_);
  ++figures_.tiles;
  figures_.bytes += tile.pixels.size();
}

// The wish as a frame; null: there is none, or its picture is as good as it becomes.
std::unique_ptr<Drawn> Exchange::NextFrame() {
  const std::scoped_lock lock(mutex_);
  if (!wish_) return nullptr;
  std::unique_ptr<Drawn> drawn = spare_ != nullptr ? std::move(spare_) : std::make_unique<Drawn>();
  drawn->wish = std::move(*wish_);
  wish_.reset();
  if (drawn->wish.is_awaited()) return drawn;
  drawn->digest = tiles::FrameDigest(drawn->wish.frame);
  const auto sample = refinement_.Next(drawn->digest);
  if (!sample) return nullptr;
  drawn->wish.frame.sample = *sample;
  return drawn;
}

void Exchange::BeginFrames() {
  while (schedule_->WantsFrame()) {
    std::unique_ptr<Drawn> drawn = NextFrame();
    if (drawn == nullptr) return;
    core::RayFrame& frame = drawn->wish.frame;
    frame.frame = ++next_frame_;
    drawn->begin_ns = core::MonotonicNow_ns();
    drawn->cost_s = 0.0;
    drawn->canvas.Resize(static_cast<int>(frame.width), static_cast<int>(frame.height));
    frames_out_.Set(frame, std::to_string(frame.frame % tiles::Schedule::kMostFrames));
    schedule_->BeginFrame(frame.frame, drawn->canvas.width, drawn->canvas.height, Seconds(drawn->begin_ns));
    in_flight_[frame.frame] = std::move(drawn);
    const std::scoped_lock lock(mutex_);
    ++figures_.begun;
  }
}

void Exchange::SendJobs() {
  const std::int64_t now_ns = core::MonotonicNow_ns();
  for (std::size_t i = 0; i < seats_.size(); ++i) {
    Seat& seat = seats_[i];
    const std::vector<tiles::Job>& jobs = schedule_->jobs(i);
    if (jobs == seat.sent && (jobs.empty() || now_ns - seat.sent_ns < kRepeat_ns)) continue;
    core::RayJobs message;
    for (const tiles::Job& job : jobs) {
      message.jobs.push_back({job.id, job.frame, static_cast<std::uint32_t>(job.tile.x),
                              static_cast<std::uint32_t>(job.tile.y), static_cast<std::uint32_t>(job.tile.width),
                              static_cast<std::uint32_t>(job.tile.height)});
    }
    seat.jobs.Send(message);
    seat.sent = jobs;
    seat.sent_ns = now_ns;
  }
}

void Exchange::Finish(std::uint64_t frame) {
  const auto found = in_flight_.find(frame);
  Drawn& drawn = *found->second;
  const bool is_shown =
      drawn.wish.is_awaited() || refinement_.Take(drawn.digest, drawn.wish.frame.sample, &drawn.canvas);
  drawn.end_ns = core::MonotonicNow_ns();
  {
    const std::scoped_lock lock(mutex_);
    figures_.cost_s += drawn.cost_s;
    if (!is_shown) spare_ = std::move(found->second);
    if (is_shown && done_ != nullptr) spare_ = std::move(done_);  // nobody has looked at it
    if (is_shown) done_ = std::move(found->second);
    ++figures_.frames;
    figures_.workers = schedule_->num_taken();
    figures_.reissued = schedule_->num_reissued();
    figures_.unused = schedule_->num_unused();
  }
  in_flight_.erase(found);
  is_done_.notify_one();
}

}  // namespace rt_visual_node
