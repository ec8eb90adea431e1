#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "view/room.hpp"

namespace view {

// How the pictures of both eyes share a window. Displays and glasses take them apart again.
enum class Stereo : std::uint8_t { kNone, kSideBySide, kTopBottom, kAnaglyph, kInterlaced };

struct StereoInfo {
  Stereo mode;
  const char* name;  // of --stereo, and of the parameter stereo.<name>
  const char* what;
};

inline constexpr std::array<StereoInfo, 4> kStereoModes = {{
    {Stereo::kSideBySide, "side_by_side", "the left eye's picture in the left half, at half its width"},
    {Stereo::kTopBottom, "top_bottom", "the left eye's picture in the upper half, at half its height"},
    {Stereo::kAnaglyph, "anaglyph", "for glasses of red (left) and cyan: Dubois' matrix of least squares"},
    {Stereo::kInterlaced, "interlaced", "the left eye's picture in the first, third, ... row from the top"},
}};

// By name; "none": kNone. None: unknown.
std::optional<Stereo> FindStereo(std::string_view name);
const char* NameOf(Stereo mode);

// Pixels of one eye's picture in a window.
glm::ivec2 EyeSize(Stereo mode, int width, int height);

// Where a person stands and looks: what decides how a camera's view becomes the picture of one window.
struct Viewing {
  Stereo stereo = Stereo::kNone;
  double eye_distance_m = kEyeDistance_m;
  core::Pose X_RH{};                 // head; the viewpoint while nothing tells where it is
  std::optional<Screen> screen_R{};  // none: the one that the camera means
};

// What the eyes see through a window of that size: one frustum, or the left eye's and the right one's, each for a
// picture of EyeSize. The rows of an interlaced window are half a row of an eye's picture apart, and so are the
// frusta. `placed` stands in W.
std::vector<Frustum> FrustaOf(const Viewing& viewing, const scene::Camera& placed, int width, int height);

// Red and cyan from both eyes' linear RGB: left * kDuboisLeft + right * kDuboisRight, a row for each channel of the
// result. The projection onto what these glasses let through, on a display with sRGB primaries, by least squares
// [Dubois 2001; coefficients for LCD and red/cyan glasses, 2009].
constexpr std::array<std::array<float, 3>, 3> kDuboisLeft = {
    {{0.437f, 0.449f, 0.164f}, {-0.062f, -0.062f, -0.024f}, {-0.048f, -0.050f, -0.017f}}};
constexpr std::array<std::array<float, 3>, 3> kDuboisRight = {
    {{-0.011f, -0.032f, -0.007f}, {0.377f, 0.761f, 0.009f}, {-0.026f, -0.093f, 1.234f}}};

}  // namespace view
