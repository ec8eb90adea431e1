#pragma once

#include <cstdint>

#include "core/fixed_vector.hpp"
#include "core/messages/trace.hpp"
#include "core/pose.hpp"
#include "core/wrench.hpp"

namespace core {

constexpr std::size_t kMaxBodies = 64;
constexpr std::size_t kMaxMechanisms = 32;
constexpr std::uint16_t kNoObject = 0xffff;

struct BodyState {
  std::uint16_t object = kNoObject;  // object index in the scenario
  Pose X_WO;                         // O: the object's mesh frame, not its centre of mass
  Twist V_WO;                        // of the object's mesh-frame origin
};

// Hinge: position is the angle [rad]. Snap: position along the axis [m], state 1 while engaged. Hook-and-loop:
// position is the number of patches that still hold.
struct MechanismState {
  std::uint16_t mechanism = 0;  // index in the scenario
  std::int32_t state = 0;       // hinge: nearest detent (0, 1); snap: 0 free, 1 engaged; hook-and-loop: patches left
  double position = 0.0;
  double force = 0.0;  // N or Nm along the axis, on the child
};

// physics/state (split by body group on the wire, complete here).
struct PhysicsState {
  Header header;
  std::uint64_t tick = 0;
  std::int64_t time_ns = 0;  // simulated time of the tick
  bool is_in_contact = false;
  std::uint64_t state_hash = 0;  // of all that the next tick starts from, impulses included; equal for equal runs
  FixedVector<BodyState, kMaxBodies> bodies;
  FixedVector<MechanismState, kMaxMechanisms> mechanisms;
};

// physics/<role>/reaction: every force that physics makes on a hand (grasp, mechanisms); contact forces are the
// haptic node's (each pair has exactly one owner).
struct Reaction {
  Header header;
  std::uint8_t role_index = 0;
  std::uint64_t tick = 0;
  std::uint16_t grasped_object = kNoObject;
  Wrench F_Do_W;
};

}  // namespace core
