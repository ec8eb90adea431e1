#pragma once

#include "tools/failures/loop.hpp"
#include "tools/failures/scene_kit.hpp"

namespace failures {

// The frame of a gripper is its palm's, in which the fingers point along -z. The jaws' inner faces are the planes
// x = -+ opening / 2, from z = -35 mm to -5 mm; what they hold ends below z = 0.
constexpr double kHeldTop_m = -0.004;

// A box, not about its own frame's origin.
vps::TriangleMesh MakeBoxAt(const glm::dvec3& size_m, const glm::dvec3& centre_m);

// The kit's first hand: a palm and two jaws, which will close on what is `width_m` wide.
void AddGripper(SceneKit* kit, const core::Pose& X_WD, double width_m);

// Pairs of the gripper's parts with an object, so that it can be held.
void AddGripPairs(SceneKit* kit, std::uint16_t object);

// A gripper, and between its jaws a box as wide as `size_m`.x, which hangs down from kHeldTop_m. Returns the box.
std::uint16_t AddHeldBox(SceneKit* kit, const core::Pose& X_WD, const glm::dvec3& size_m, double mass_kg,
                         double voxel_m, std::uint32_t num_points);

constexpr double kSqueeze_m = 1e-4;  // of each jaw, closed

// Closes the jaws of a gripper at rest on what is `width_m` wide, and waits until all is still. An error of the program
// if physics_node does not report a grasp then.
void Grip(Loop* loop, const core::Pose& X_WD, double width_m, double squeeze_m = kSqueeze_m);

// Rms about the mean.
double Spread(const std::vector<glm::dvec3>& values);

}  // namespace failures
