#pragma once

#include <cstdint>

#include "core/fixed_vector.hpp"
#include "core/messages/trace.hpp"
#include "core/pose.hpp"
#include "core/wrench.hpp"

namespace core {

// haptic/<role>/proxy, every haptic cycle: the hand as the device holds it (D) and as the contact allows it (C).
// Viewers draw X_WC; physics_node couples to X_WD, so that what moves the object is what the hand feels.
struct HapticProxy {
  Header header;
  std::uint8_t role_index = 0;
  std::uint64_t cycle = 0;  // haptic cycle; also the tick that triggers physics_node
  Pose X_WD;
  Twist V_WD;
  Pose X_WC;  // virtual coupling pose [VR-OOS, Eq. 3-5]
  double opening_m = 0.0;
  bool is_in_contact = false;
  bool is_engaged = false;
  Wrench F_Do_W;  // coupling wrench on the hand [VR-OOS, Eq. 6], before reaction and cap
};

// A contact between S (sampled body) and G (field body), architecture D5: a point fixed in S, a plane fixed in G.
// The receiver re-evaluates gap = n_G . (X_GS p_S - q_G) with its own current poses at each of its own ticks.
struct ContactPlane {
  std::uint32_t id = 0;         // stable from cycle to cycle while the contact lasts
  glm::vec3 p_S{0.0f};          // contact point, m, in S
  glm::vec3 q_G{0.0f};          // point on the plane, m, in G
  glm::vec3 n_G{0.0f};          // unit normal, from G to S, in G
  float stiffness_N_per_m = 0;  // of this plane; the pair's total is the sum over its penetrating planes
};

constexpr std::size_t kMaxContactPlanes = 20;

// contacts/<source>/<pair>: complete in itself. Sent also with positive gaps within the look-ahead margin.
struct ContactSet {
  Header header;
  std::uint16_t pair_index = 0;    // into scene::Scenario::pairs
  std::uint16_t sampled_body = 0;  // S, object index
  std::uint16_t field_body = 0;    // G, object index
  std::uint64_t cycle = 0;
  double signed_distance_m = 0.0;  // deepest; negative inside; a lower bound when apart
  bool is_in_contact = false;
  Wrench F_So_W;  // method `wrench`: on S about S's object origin, in W; G gets the opposite at the same point
  float damping_N_s_per_m = 0;
  float friction = 0;
  FixedVector<ContactPlane, kMaxContactPlanes> planes;
};

}  // namespace core
