#include "view/bus_feed.hpp"

namespace view {

BusFeed::BusFeed(const scene::Scenario& scenario, bus::Node* node)
    : physics_(&node->ReadLatest<core::PhysicsState>(bus::kPhysicsStateTopic)),
      logic_(&node->ReadState<core::LogicStatus>(bus::kLogicStatusTopic)),
      bridge_(&node->ReadState<bus::Figures>(bus::FiguresTopic("device_bridge"))) {
  for (const scene::Device& device : scenario.devices) {
    proxies_.push_back(&node->ReadLatest<core::HapticProxy>(bus::HapticProxyTopic(device.role)));
    commands_.push_back(&node->ReadLatest<core::DeviceCommand>(bus::DeviceCommandTopic(device.role)));
  }
  for (const char* source : {"haptic_node", "physics_node"}) {
    collisions_.push_back(&node->ReadLatest<core::CollisionMatrix>(bus::CollisionsTopic(source)));
  }
  for (std::size_t i = 0; i < scenario.pairs.size(); ++i) {
    const std::string topic = bus::ContactsTopic(scenario.PairSource(i), scenario.PairName(i));
    contacts_.push_back(&node->ReadLatest<core::ContactSet>(topic));
  }
  for (const scene::Object& object : scenario.objects) {
    if (object.sheet) sheets_.push_back(&node->ReadLatest<core::SheetState>(bus::SheetTopic(object.name)));
  }
}

bool BusFeed::Apply(std::int64_t now_ns, SceneMirror* mirror) const {
  for (const auto* proxy : proxies_) {
    if (proxy->is_fresh()) mirror->Apply(proxy->value());
  }
  for (const auto* command : commands_) {
    if (command->is_fresh()) mirror->Apply(command->value(), now_ns);
  }
  for (std::size_t i = 0; i < collisions_.size(); ++i) {
    if (collisions_[i]->is_fresh()) mirror->Apply(collisions_[i]->value(), i, now_ns);
  }
  for (const auto* contacts : contacts_) {
    if (contacts->is_fresh()) mirror->Apply(contacts->value(), now_ns);
  }
  for (const auto* sheet : sheets_) {
    if (sheet->is_fresh()) mirror->Apply(sheet->value());
  }
  if (logic_->is_fresh()) mirror->Apply(logic_->value());
  if (bridge_->is_fresh()) mirror->ApplyBridge(bridge_->value());
  if (!physics_->is_fresh()) return false;
  mirror->Apply(physics_->value());
  return true;
}

}  // namespace view
