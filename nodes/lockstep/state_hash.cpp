#include "nodes/lockstep/state_hash.hpp"

#include "core/hash.hpp"

namespace lockstep {

void StateHash::Add(std::uint64_t number) {
  value_ = core::Hash64(&number, sizeof number, value_);
}
void StateHash::Add(double number) {
  value_ = core::Hash64(&number, sizeof number, value_);
}

void StateHash::Add(const glm::dvec3& vector) {
  const double numbers[] = {vector.x, vector.y, vector.z};
  value_ = core::Hash64(numbers, sizeof numbers, value_);
}

void StateHash::Add(const core::Pose& pose) {
  const double numbers[] = {pose.rotation.w,    pose.rotation.x,    pose.rotation.y,   pose.rotation.z,
                            pose.translation.x, pose.translation.y, pose.translation.z};
  value_ = core::Hash64(numbers, sizeof numbers, value_);
}

void StateHash::Add(const core::PhysicsState& state) {
  Add(state.tick);
  Add(state.state_hash);
  for (const core::BodyState& body : state.bodies) {
    Add(static_cast<std::uint64_t>(body.object));
    Add(body.X_WO);
    Add(body.V_WO.angular_rad_per_s);
    Add(body.V_WO.linear_m_per_s);
  }
  for (const core::MechanismState& mechanism : state.mechanisms) {
    Add(static_cast<std::uint64_t>(static_cast<std::uint32_t>(mechanism.state)));
    Add(mechanism.position);
    Add(mechanism.force);
  }
}

void StateHash::Add(const core::DeviceCommand& command) {
  Add(command.F_Do_W.force_N);
  Add(command.F_Do_W.torque_Nm);
  Add(command.grip_force_N);
}

void StateHash::Add(const core::DeviceState& device) {
  Add(device.X_WD);
  Add(device.opening_m);
  for (const double angle_rad : device.finger_rad) Add(angle_rad);
}

}  // namespace lockstep
