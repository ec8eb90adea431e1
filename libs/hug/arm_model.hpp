#pragma once

#include <vector>

#include "core/pose.hpp"
#include "hug/joints.hpp"
#include "physics/chain/chain.hpp"

namespace hug {

inline constexpr double kFlange_m = 0.078;  // from the last joint to the flange F, along its z

// What is mounted on the flange F beyond the wrist's force sensor: the magnetic clutch and the gripper that the hand
// holds, as a point mass at the hand frame D.
struct HandMount {
  core::Pose X_FD{glm::dquat(1, 0, 0, 0), {0.0, 0.0, 0.132}};
  double mass_kg = 0.4;  // assumed
};

// One arm of HUG: links, joints and motors. The last link has the flange frame F; its mass includes the hand's mount.
struct ArmModel {
  std::vector<physics::ChainLink> links;
  HandMount mount;
  Joints limit{};       // joints turn from -limit to limit [rad]
  Joints max_speed{};   // [rad/s]
  Joints max_torque{};  // of the motors at the output [Nm]
  Joints ready{};       // posture in the middle of the workspace, flange down [rad]
};

// A light-weight robot of DLR's, as a KUKA LWR4+: axes and lengths, joint limits, speeds and torques are published;
// how the mass is distributed over the links, and the rotors' inertias, are assumed.
ArmModel LightWeightRobot(const HandMount& mount);

// Frame of the hand for joint angles q, the base at the origin: the product of the Denavit-Hartenberg transforms, with
// the table as it is published. Slow; an oracle for the chain.
core::Pose DenavitHartenbergX_BF(const Joints& q);

}  // namespace hug
