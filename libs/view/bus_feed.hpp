#pragma once

#include <cstdint>
#include <vector>

#include "bus/node.hpp"
#include "scene/scenario.hpp"
#include "view/scene_mirror.hpp"

namespace view {

// Fills a scene from the bus: all that a viewer reads, whatever it draws with. Poses, contacts and sheets come whole in
// every message, and the procedure's state is retained, so a viewer that joins late has the whole scene with the first
// message of each.
class BusFeed {
 public:
  // Declares what is read: before the node's Start. Both must outlive the feed.
  BusFeed(const scene::Scenario& scenario, bus::Node* node);

  // After the node's Wait: applies what it brought. True when a physics state was among it.
  bool Apply(std::int64_t now_ns, SceneMirror* mirror) const;

  // The newest of what Apply told of.
  [[nodiscard]] const bus::LatestReader<core::PhysicsState>& physics() const { return *physics_; }
  [[nodiscard]] const bus::StateReader<core::LogicStatus>& logic() const { return *logic_; }

 private:
  const bus::LatestReader<core::PhysicsState>* physics_;
  const bus::StateReader<core::LogicStatus>* logic_;
  std::vector<const bus::LatestReader<core::HapticProxy>*> proxies_;
  std::vector<const bus::LatestReader<core::ContactSet>*> contacts_;
  std::vector<const bus::LatestReader<core::SheetState>*> sheets_;
};

}  // namespace view
