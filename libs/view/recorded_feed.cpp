#include "view/recorded_feed.hpp"

#include "bus/topics.hpp"
#include "bus/wire/codec.hpp"
#include "view/bus_feed.hpp"

namespace view {
namespace {

template <class M>
bool Decode(const bus::log::Message& message, M* value) {
  return bus::DecodeState(std::string(message.data.begin(), message.data.end()), value);
}

}  // namespace

bool RecordedFeed::IsRead(const bus::log::Channel& channel) {
  const auto tap = channel.metadata.find("tap");
  if (tap != channel.metadata.end() && tap->second != "sent") return false;
  const bus::TopicRule* rule = bus::FindTopicRule(channel.topic);
  if (rule == nullptr || channel.message_encoding != "protobuf") return false;
  switch (rule->type) {
    case bus::MessageType::kPhysicsState:
    case bus::MessageType::kHapticProxy:
    case bus::MessageType::kDeviceCommand:
    case bus::MessageType::kDeviceJoints:
    case bus::MessageType::kTactileState:
    case bus::MessageType::kContactSet:
    case bus::MessageType::kCollisionMatrix:
    case bus::MessageType::kSheetState:
    case bus::MessageType::kLogicStatus:
    case bus::MessageType::kDeviceHealth:
      return true;
    case bus::MessageType::kFigures:
      return channel.topic == BusFeed::BridgeTopic() || channel.topic == BusFeed::HapticTopic();
    default:
      return false;
  }
}

void RecordedFeed::Apply(const bus::log::Channel& channel, const bus::log::Message& message, SceneMirror* mirror) {
  if (!IsRead(channel)) return;
  const bus::log::RecordedPayload recorded = bus::log::SplitRecorded(message.data);
  const auto now_ns = static_cast<std::int64_t>(message.log_time_ns);
  switch (bus::FindTopicRule(channel.topic)->type) {
    case bus::MessageType::kPhysicsState:
      if (const auto* state = physics_[channel.topic].Take(recorded)) mirror->Apply(*state);
      break;
    case bus::MessageType::kHapticProxy:
      if (const auto* proxy = proxies_[channel.topic].Take(recorded)) mirror->Apply(*proxy);
      break;
    case bus::MessageType::kDeviceCommand:
      if (const auto* command = commands_[channel.topic].Take(recorded)) mirror->Apply(*command, now_ns);
      break;
    case bus::MessageType::kDeviceJoints:
      if (const auto* joints = joints_[channel.topic].Take(recorded)) mirror->Apply(*joints, now_ns);
      break;
    case bus::MessageType::kTactileState:
      if (const auto* state = tactiles_[channel.topic].Take(recorded)) mirror->Apply(*state, now_ns);
      break;
    case bus::MessageType::kContactSet:
      if (const auto* contacts = contacts_[channel.topic].Take(recorded)) mirror->Apply(*contacts, now_ns);
      break;
    case bus::MessageType::kCollisionMatrix:
      if (const auto* matrix = collisions_[channel.topic].Take(recorded)) {
        for (std::size_t i = 0; i < std::size(kCollisionSources); ++i) {
          if (channel.topic == bus::CollisionsTopic(kCollisionSources[i])) mirror->Apply(*matrix, i, now_ns);
        }
      }
      break;
    case bus::MessageType::kSheetState:
      if (const auto* sheet = sheets_[channel.topic].Take(recorded)) mirror->Apply(*sheet);
      break;
    case bus::MessageType::kLogicStatus:
      if (core::LogicStatus status; Decode(message, &status)) mirror->Apply(status);
      break;
    case bus::MessageType::kDeviceHealth:
      if (core::DeviceHealth health; Decode(message, &health)) mirror->Apply(health);
      break;
    default:
      if (core::Figures figures; Decode(message, &figures)) {
        channel.topic == BusFeed::BridgeTopic() ? mirror->ApplyBridge(figures) : mirror->ApplyHaptic(figures);
      }
      break;
  }
}

}  // namespace view
