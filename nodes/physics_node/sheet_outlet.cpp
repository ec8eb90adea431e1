#include "nodes/physics_node/sheet_outlet.hpp"

namespace physics_node {

void SheetOutlet::Declare(const scene::Scenario& scenario, const SheetKeeper& sheets, bus::Node* node) {
  for (std::size_t i = 0; i < sheets.num_sheets(); ++i) {
    const std::string& name = scenario.objects[static_cast<std::size_t>(sheets.object(i))].name;
    outlets_.push_back({node->WriteLatest<core::SheetState>(bus::SheetTopic(name)), 0});
  }
}

void SheetOutlet::Send(const SheetKeeper& sheets, std::uint64_t tick) {
  for (std::size_t i = 0; i < outlets_.size(); ++i) {
    Outlet& outlet = outlets_[i];
    if (tick < outlet.next_tick) continue;
    outlet.next_tick = tick + (sheets.is_active(i) ? kAwake_ticks : kAsleep_ticks);
    sheets.FillState(i, tick, &state_);
    outlet.writer.Send(state_);
  }
}

}  // namespace physics_node
