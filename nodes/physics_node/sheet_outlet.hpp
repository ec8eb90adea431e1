#pragma once

#include <vector>

#include "bus/node.hpp"
#include "nodes/physics_node/sheet_keeper.hpp"

namespace physics_node {

// Publishes the sheets' nodes: at the rate of a display, 60 Hz, while they are active; at 2 Hz while inactive, for
// viewers that join late.
class SheetOutlet {
 public:
  static constexpr std::uint64_t kAwake_ticks = 16;
  static constexpr std::uint64_t kAsleep_ticks = 512;

  void Declare(const scene::Scenario& scenario, const SheetKeeper& sheets, bus::Node* node);
  void Send(const SheetKeeper& sheets, std::uint64_t tick);

 private:
  struct Outlet {
    bus::LatestWriter<core::SheetState> writer;
    std::uint64_t next_tick = 0;
  };
  std::vector<Outlet> outlets_;  // per sheet
  core::SheetState state_;
};

}  // namespace physics_node
