#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bus/node.hpp"
#include "scene/scenario.hpp"
#include "view/scene_mirror.hpp"

namespace view {

// Of the matrices that SceneMirror takes, by the index that it takes.
inline constexpr const char* kCollisionSources[] = {"haptic_node", "physics_node"};

// Reads every topic that a viewer needs and applies it to a scene, for any renderer. Each message of poses, contacts
// and sheets is complete, and the procedure's state is retained by the bus, so a viewer that joins late has the whole
// scene after the first message of each topic.
class BusFeed {
 public:
  // Declares the topics that it reads, so it is built before the node's Start. `node` must outlive the feed.
  BusFeed(const scene::Scenario& scenario, bus::Node* node);

  // Applies the messages that the node's last Wait received. True when a physics state was among them.
  bool Apply(std::int64_t now_ns, SceneMirror* mirror) const;

  // Of the hands' margins, and of late cycles.
  static std::string BridgeTopic() { return bus::FiguresTopic("device_bridge"); }
  static std::string HapticTopic() { return bus::FiguresTopic("haptic_node"); }

  // The newest messages.
  [[nodiscard]] const bus::LatestReader<core::PhysicsState>& physics() const { return *physics_.reader; }
  [[nodiscard]] const bus::StateReader<core::LogicStatus>& logic() const { return *logic_.reader; }

  // Calls visit(topic, writer, reader) for each LATEST topic, or each STATE topic.
  template <class Visitor>
  void VisitLatest(Visitor&& visit) const {
    const auto all = [&](const auto& sources) {
      for (const auto& source : sources) visit(source.topic, source.writer, *source.reader);
    };
    visit(physics_.topic, physics_.writer, *physics_.reader);
    all(proxies_);
    all(commands_);
    all(joints_);
    all(tactiles_);
    all(contacts_);
    all(collisions_);
    all(sheets_);
  }
  template <class Visitor>
  void VisitStates(Visitor&& visit) const {
    visit(logic_.topic, logic_.writer, *logic_.reader);
    for (const auto& source : {bridge_, haptic_}) visit(source.topic, source.writer, *source.reader);
    for (const auto& source : health_) visit(source.topic, source.writer, *source.reader);
  }

 private:
  template <class Reader>
  struct Source {
    std::string topic;
    std::string writer;
    const Reader* reader = nullptr;
  };
  template <class M>
  using Latest = Source<bus::LatestReader<M>>;
  template <class M>
  using State = Source<bus::StateReader<M>>;

  Latest<core::PhysicsState> physics_;
  State<core::LogicStatus> logic_;
  State<bus::Figures> bridge_;
  State<bus::Figures> haptic_;
  std::vector<State<core::DeviceHealth>> health_;
  std::vector<Latest<core::HapticProxy>> proxies_;
  std::vector<Latest<core::DeviceCommand>> commands_;
  std::vector<Latest<core::DeviceJoints>> joints_;  // of devices that are robots; others never send
  std::vector<Latest<core::TactileState>> tactiles_;
  std::vector<Latest<core::ContactSet>> contacts_;
  std::vector<Latest<core::CollisionMatrix>> collisions_;  // of the nodes that compute pairs
  std::vector<Latest<core::SheetState>> sheets_;
};

}  // namespace view
