#include "nodes/visual_node/walls/wall_link.hpp"

#include <chrono>
#include <limits>

#include "core/clock.hpp"

namespace visual_node {

void WallLink::Declare(bus::Node* node) {
  const std::string& room = place_.room;
  state_writer_ = node->WriteLatest<core::WallState>(bus::WallStateTopic(room, place_.walls[place_.own]));
  if (place_.is_first()) {
    frame_writer_ = node->WriteLatest<core::WallFrame>(bus::WallFrameTopic(room));
  } else {
    frame_reader_ = &node->ReadLatest<core::WallFrame>(bus::WallFrameTopic(room));
  }
  clock_offsets_ns_.assign(place_.walls.size(), 0);
  state_readers_.assign(place_.walls.size(), nullptr);
  if (!place_.is_first()) return;
  for (std::size_t i = 1; i < place_.walls.size(); ++i) {
    state_readers_[i] = &node->ReadLatest<core::WallState>(bus::WallStateTopic(room, place_.walls[i]));
  }
}

void WallLink::UpdateClocks(const bus::Node& node, std::int64_t now_ns) {
  if (now_ns < next_clocks_ns_) return;
  next_clocks_ns_ = now_ns + core::kNanosecondsPerSecond;
  for (const bus::PeerStatus& peer : node.Peers()) {
    for (std::size_t i = 0; i < place_.walls.size(); ++i) {
      const bool is_known = peer.clock_offset_ns != std::numeric_limits<std::int64_t>::max();
      if (is_known && peer.name == "visual_node-" + place_.walls[i]) clock_offsets_ns_[i] = peer.clock_offset_ns;
    }
  }
}

void WallLink::Pump(bus::Node* node, const KeptTicks& kept, std::int64_t now_ns) {
  UpdateClocks(*node, now_ns);
  const std::unique_lock lock(mutex_);
  const std::uint64_t before = news_;
  if (frame_reader_ != nullptr && frame_reader_->is_fresh()) {
    heard_ = {frame_reader_->value(), frame_reader_->received_ns()};
    heard_.frame.show_ns -= clock_offsets_ns_[0];
    ++news_;
  }
  for (std::size_t i = 0; i < state_readers_.size(); ++i) {
    if (state_readers_[i] == nullptr || !state_readers_[i]->is_fresh()) continue;
    states_[i] = {state_readers_[i]->value(), state_readers_[i]->received_ns()};
    states_[i].state.shown_ns -= clock_offsets_ns_[i];
    ++news_;
  }
  if (news_ != before) heard_something_.notify_all();
  if (!is_new_ && now_ns < next_send_ns_) return;
  is_new_ = false;
  next_send_ns_ = now_ns + kRepeat_ns;
  if (is_frame_said_) frame_writer_.Send(own_frame_);
  if (!is_state_said_) return;
  own_state_.kept_tick = kept.newest;
  own_state_.kept = kept.kept;
  state_writer_.Send(own_state_);
}

std::uint64_t WallLink::named_tick() const {
  const std::scoped_lock lock(mutex_);
  return place_.is_first() ? own_frame_.tick : heard_.frame.tick;
}

void WallLink::Say(const core::WallFrame& frame) {
  const std::scoped_lock lock(mutex_);
  own_frame_ = frame;
  is_frame_said_ = is_new_ = true;
}

void WallLink::Say(const core::WallState& state) {
  const std::scoped_lock lock(mutex_);
  own_state_ = state;
  is_state_said_ = is_new_ = true;
}

WallLink::HeardFrame WallLink::frame() const {
  const std::scoped_lock lock(mutex_);
  return heard_;
}

std::vector<WallLink::HeardState> WallLink::states() const {
  const std::scoped_lock lock(mutex_);
  return states_;
}

void WallLink::Wait(std::int64_t until_ns) {
  std::unique_lock lock(mutex_);
  const std::chrono::nanoseconds left(until_ns - core::MonotonicNow_ns());
  heard_something_.wait_for(lock, left, [this] { return news_ != news_seen_; });
  news_seen_ = news_;
}

}  // namespace visual_node
