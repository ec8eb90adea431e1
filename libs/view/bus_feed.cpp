#include "view/bus_feed.hpp"

namespace view {

BusFeed::BusFeed(const scene::Scenario& scenario, bus::Node* node) {
  const auto read_latest = [node](const std::string& topic, const char* writer, auto* source) {
    using M = std::decay_t<decltype(source->reader->value())>;
    *source = {topic, writer, &node->ReadLatest<M>(topic)};
  };
  const auto add_latest = [&](const std::string& topic, const char* writer, auto* sources) {
    read_latest(topic, writer, &sources->emplace_back());
  };
  read_latest(bus::kPhysicsStateTopic, "physics_node", &physics_);
  logic_ = {bus::kLogicStatusTopic, "logic_node", &node->ReadState<core::LogicStatus>(bus::kLogicStatusTopic)};
  bridge_ = {BridgeTopic(), "device_bridge", &node->ReadState<bus::Figures>(BridgeTopic())};
  haptic_ = {HapticTopic(), "haptic_node", &node->ReadState<bus::Figures>(HapticTopic())};
  for (const scene::Device& device : scenario.devices) {
    add_latest(bus::HapticProxyTopic(device.role), "haptic_node", &proxies_);
    add_latest(bus::DeviceCommandTopic(device.role), "haptic_node", &commands_);
    const std::string health = bus::DeviceHealthTopic(device.role);
    health_.push_back({health, "device_bridge", &node->ReadState<core::DeviceHealth>(health)});
    add_latest(bus::DeviceJointsTopic(device.role), "device_bridge", &joints_);
  }
  for (const scene::Tactile& tactile : scenario.tactiles) {
    add_latest(bus::TactileStateTopic(tactile.name), "device_bridge", &tactiles_);
  }
  for (const char* source : kCollisionSources) add_latest(bus::CollisionsTopic(source), source, &collisions_);
  for (std::size_t i = 0; i < scenario.pairs.size(); ++i) {
    const char* source = scenario.PairSource(i);
    add_latest(bus::ContactsTopic(source, scenario.PairName(i)), source, &contacts_);
  }
  for (const scene::Object& object : scenario.objects) {
    if (object.sheet) add_latest(bus::SheetTopic(object.name), "physics_node", &sheets_);
  }
}

bool BusFeed::Apply(std::int64_t now_ns, SceneMirror* mirror) const {
  for (const auto& proxy : proxies_) {
    if (proxy.reader->is_fresh()) mirror->Apply(proxy.reader->value());
  }
  for (const auto& command : commands_) {
    if (command.reader->is_fresh()) mirror->Apply(command.reader->value(), now_ns);
  }
  for (const auto& joints : joints_) {
    if (joints.reader->is_fresh()) mirror->Apply(joints.reader->value(), now_ns);
  }
  for (const auto& tactile : tactiles_) {
    if (tactile.reader->is_fresh()) mirror->Apply(tactile.reader->value(), now_ns);
  }
  for (std::size_t i = 0; i < collisions_.size(); ++i) {
    if (collisions_[i].reader->is_fresh()) mirror->Apply(collisions_[i].reader->value(), i, now_ns);
  }
  for (const auto& contacts : contacts_) {
    if (contacts.reader->is_fresh()) mirror->Apply(contacts.reader->value(), now_ns);
  }
  for (const auto& sheet : sheets_) {
    if (sheet.reader->is_fresh()) mirror->Apply(sheet.reader->value());
  }
  if (logic_.reader->is_fresh()) mirror->Apply(logic_.reader->value());
  for (const auto& health : health_) {
    if (health.reader->is_fresh()) mirror->Apply(health.reader->value());
  }
  if (bridge_.reader->is_fresh()) mirror->ApplyBridge(bridge_.reader->value());
  if (haptic_.reader->is_fresh()) mirror->ApplyHaptic(haptic_.reader->value());
  if (!physics().is_fresh()) return false;
  mirror->Apply(physics().value());
  return true;
}

}  // namespace view
