#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "bus/node.hpp"
#include "core/messages/viewing.hpp"
#include "nodes/visual_node/walls/kept_ticks.hpp"

namespace visual_node {

// Which wall of which room this viewer is. The first wall leads. A wall's node is called visual_node-<wall>.
struct WallPlace {
  std::string room;
  std::vector<std::string> walls;
  std::size_t own = 0;

  [[nodiscard]] bool is_first() const { return own == 0; }
};

// Between the thread that draws a wall and the one that has the bus: what each has to say to the other walls, and hears
// from them. What is said is sent at once and again every 5 ms, because a datagram can be lost.
class WallLink {
 public:
  explicit WallLink(WallPlace place) : place_(std::move(place)), states_(place_.walls.size()) {}
  [[nodiscard]] const WallPlace& place() const { return place_; }

  // --- The bus's thread.
  void Declare(bus::Node* node);  // before Node::Start
  void Pump(bus::Node* node, const KeptTicks& kept, std::int64_t now_ns);
  // The physics state of the newest frame, by the first wall; 0: none yet.
  [[nodiscard]] std::uint64_t named_tick() const;

  // --- The drawing thread.
  void Say(const core::WallFrame& frame);  // the first wall's
  void Say(const core::WallState& state);  // what it keeps is added by Pump

  struct HeardFrame {
    core::WallFrame frame;      // `show_ns` on this host's clock
    std::int64_t heard_ns = 0;  // 0: never
  };
  struct HeardState {
    core::WallState state;  // `shown_ns` on this host's clock
    std::int64_t heard_ns = 0;
  };
  [[nodiscard]] HeardFrame frame() const;
  [[nodiscard]] std::vector<HeardState> states() const;  // by wall; this one's own is empty
  // Until something new is heard, or the time has come.
  void Wait(std::int64_t until_ns);

 private:
  static constexpr std::int64_t kRepeat_ns = 5'000'000;

  void UpdateClocks(const bus::Node& node, std::int64_t now_ns);

  WallPlace place_;
  // The bus's thread only.
  bus::LatestWriter<core::WallFrame> frame_writer_;
  bus::LatestWriter<core::WallState> state_writer_;
  const bus::LatestReader<core::WallFrame>* frame_reader_ = nullptr;
  std::vector<const bus::LatestReader<core::WallState>*> state_readers_;  // by wall; null: this one
  std::vector<std::int64_t> clock_offsets_ns_;                            // by wall: its clock minus this one's
  std::int64_t next_clocks_ns_ = 0;
  std::int64_t next_send_ns_ = 0;

  mutable std::mutex mutex_;
  std::condition_variable heard_something_;
  HeardFrame heard_;
  std::vector<HeardState> states_;
  core::WallFrame own_frame_;
  core::WallState own_state_;
  bool is_frame_said_ = false, is_state_said_ = false;
  bool is_new_ = false;     // to be sent at once
  std::uint64_t news_ = 0;  // counts what was heard
  std::uint64_t news_seen_ = 0;
};

}  // namespace visual_node
