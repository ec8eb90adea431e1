#pragma once

#include <cstdint>
#include <vector>

#include "bus/node.hpp"
#include "scene/scenario.hpp"
#include "view/scene_mirror.hpp"

namespace view {

// Reads every topic that a viewer needs and applies it to a scene, for any renderer. Each message of poses, contacts
// and sheets is complete, and the procedure's state is retained by the bus, so a viewer that joins late has the whole
// scene after the first message of each topic.
class BusFeed {
 public:
  // Declares the topics that it reads, so it is built before the node's Start. `node` must outlive the feed.
  BusFeed(const scene::Scenario& scenario, bus::Node* node);

  // Applies the messages that the node's last Wait received. True when a physics state was among them.
  bool Apply(std::int64_t now_ns, SceneMirror* mirror) const;

  // The newest messages.
  [[nodiscard]] const bus::LatestReader<core::PhysicsState>& physics() const { return *physics_; }
  [[nodiscard]] const bus::StateReader<core::LogicStatus>& logic() const { return *logic_; }

 private:
  const bus::LatestReader<core::PhysicsState>* physics_;
  const bus::StateReader<core::LogicStatus>* logic_;
  std::vector<const bus::LatestReader<core::HapticProxy>*> proxies_;
  std::vector<const bus::LatestReader<core::DeviceCommand>*> commands_;
  std::vector<const bus::LatestReader<core::ContactSet>*> contacts_;
  std::vector<const bus::LatestReader<core::CollisionMatrix>*> collisions_;  // of the nodes that compute pairs
  const bus::StateReader<bus::Figures>* bridge_;
  std::vector<const bus::LatestReader<core::SheetState>*> sheets_;
};

}  // namespace view
