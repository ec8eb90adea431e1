#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "nodes/device_bridge/tactile/body_poses.hpp"
#include "tactile/electro/finger_contact.hpp"
#include "tactile/touch.hpp"

namespace device_bridge {

// A set of contacts as it came; none: not yet.
struct SeenContacts {
  const core::ContactSet* set = nullptr;
  std::int64_t received_ns = 0;
};

// From the contacts of a body to what the person who wears a device there feels. No allocation.
class BodyTouch {
 public:
  BodyTouch(const scene::Scenario& scenario, const scene::Tactile& tactile);

  // Indices of the pairs that the body is in: whose contacts Step wants, in this order.
  [[nodiscard]] const std::vector<std::size_t>& pairs() const { return pairs_; }
  void Step(std::int64_t now_ns, std::span<const SeenContacts> contacts, const BodyPoses& poses) noexcept;

  [[nodiscard]] const tactile::Touch& touch() const { return touch_; }
  [[nodiscard]] const glm::dvec3& towards_B() const { return towards_B_; }
  [[nodiscard]] double strength() const { return strength_; }  // 0 to 1
  [[nodiscard]] const tactile::FingerContact& finger() const { return finger_; }

  // Contacts are sent a thousand times a second while there are any. Older ones are of a node that has stopped.
  static constexpr std::int64_t kContactAge_ns = 10'000'000;

 private:
  const scene::Tactile& tactile_;
  std::vector<std::size_t> pairs_;
  tactile::Touch touch_;
  tactile::FingerSense sense_;
  tactile::FingerContact finger_;
  glm::dvec3 towards_B_{0.0};
  double strength_ = 0.0;
};

}  // namespace device_bridge
