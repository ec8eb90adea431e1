#pragma once

#include <map>
#include <string>

#include "bus/log/mcap_records.hpp"
#include "bus/log/recorded_message.hpp"
#include "view/scene_mirror.hpp"

namespace view {

// Applies recorded messages to a scene, as BusFeed applies those of the bus. Messages come in the order of their times.
class RecordedFeed {
 public:
  // Whether a viewer reads this channel: messages that nodes received are copies of those that others sent.
  static bool IsRead(const bus::log::Channel& channel);

  // Of a channel that a viewer reads; others change nothing.
  void Apply(const bus::log::Channel& channel, const bus::log::Message& message, SceneMirror* mirror);

 private:
  template <class M>
  using ByTopic = std::map<std::string, bus::log::RecordedMessage<M>>;
  ByTopic<core::PhysicsState> physics_;
  ByTopic<core::HapticProxy> proxies_;
  ByTopic<core::DeviceCommand> commands_;
  ByTopic<core::DeviceJoints> joints_;
  ByTopic<core::TactileState> tactiles_;
  ByTopic<core::ContactSet> contacts_;
  ByTopic<core::CollisionMatrix> collisions_;
  ByTopic<core::SheetState> sheets_;
};

}  // namespace view
