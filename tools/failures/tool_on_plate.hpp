#pragma once

#include "tools/failures/scene_kit.hpp"

namespace failures {

constexpr double kBall_m = 0.02;   // radius of the tool
constexpr double kVoxel_m = 1e-3;  // of the plate
constexpr double kPlate_m = 0.04;  // its thickness
constexpr std::uint32_t kToolPoints = 4096;

// A ball as tool, `gap_m` over a fixed plate whose top is the plane z = 0.
SceneKit BallOverPlate(const Variant& variant, double gap_m);

}  // namespace failures
