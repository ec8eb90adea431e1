#pragma once

#include <string>

namespace core {

// Names of haptic_node's parameters, and of device_bridge's figures, that limit the coupling of a hand by the measured
// delay of its force loop: the share of the scenario's stiffness that is stable (in the figures it may be above 1), and
// the largest damping.
inline std::string StiffnessLimitName(const std::string& role) {
  return "hand." + role + ".stiffness_limit";
}
inline std::string DampingLimitName(const std::string& role) {
  return "hand." + role + ".damping_limit_N_s_per_m";
}
inline std::string TurnDampingLimitName(const std::string& role) {
  return "hand." + role + ".damping_limit_Nm_s_per_rad";
}

// A figure of device_bridge: what is read from the muscles of a hand, as a share of its strongest grip; below zero: too
// many channels have faults.
inline std::string MuscleShareName(const std::string& role) {
  return "hand." + role + ".muscle_share";
}

}  // namespace core
