#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/pose.hpp"
#include "view/frustum.hpp"

namespace view {

// The room R in which a person stands before one screen or several: x to the right, y ahead, z up. Its origin, the
// viewpoint, is where the eyes are expected. A camera carries the room through the scene: the viewpoint is the camera's
// eye, and ahead is where it looks. A metre of the room is a metre of the scene.
//
// A head's frame H has the same directions when the person looks ahead; its origin is between the eyes.

// Without measurement: a mean distance of adults' pupils [Dodgson 2004: 63 mm].
constexpr double kEyeDistance_m = 0.063;
constexpr double kMostEyeDistance_m = 0.2;  // wider than any head's, for scenes that are far away

// What is known of where a head is.
enum class HeadSource : std::uint8_t { kNotWanted, kMissing, kSimulated, kTracked };
struct Head {
  core::Pose X_RH;  // kNotWanted, kMissing: at the viewpoint
  HeadSource source = HeadSource::kNotWanted;
};
// For people; empty: not wanted.
std::string Describe(const Head& head, const std::string& user);

// X_WR. `placed` stands in W.
core::Pose RoomOf(const scene::Camera& placed);

// The screen that a camera means, in R: upright to its view at what it looks at, and as large as its picture there. So
// an eye at the viewpoint sees through it what the camera sees, and what the camera looks at is at the screen.
Screen ScreenOf(const scene::Camera& placed, double aspect);

Screen Place(const core::Pose& X_WR, const Screen& screen_R);

// A camera that carries the room there.
scene::Camera CameraOf(const core::Pose& X_WR);

// The left eye and the right one, in the frame of X_RH's left index.
std::array<glm::dvec3, 2> EyesOf(const core::Pose& X_RH, double eye_distance_m);

}  // namespace view
