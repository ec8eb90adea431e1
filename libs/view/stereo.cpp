#include "view/stereo.hpp"

namespace view {

std::optional<Stereo> FindStereo(std::string_view name) {
  if (name == NameOf(Stereo::kNone)) return Stereo::kNone;
  for (const StereoInfo& info : kStereoModes) {
    if (name == info.name) return info.mode;
  }
  return std::nullopt;
}

const char* NameOf(Stereo mode) {
  for (const StereoInfo& info : kStereoModes) {
    if (mode == info.mode) return info.name;
  }
  return "none";
}

glm::ivec2 EyeSize(Stereo mode, int width, int height) {
  if (mode == Stereo::kSideBySide) return {(width + 1) / 2, height};
  if (mode == Stereo::kTopBottom || mode == Stereo::kInterlaced) return {width, (height + 1) / 2};
  return {width, height};
}

std::vector<Frustum> FrustaOf(const Viewing& viewing, const scene::Camera& placed, int width, int height) {
  const double aspect = static_cast<double>(width) / height;
  const core::Pose X_WR = RoomOf(placed);
  const Screen screen_R = viewing.screen_R ? *viewing.screen_R : ScreenOf(placed, aspect);
  const Screen screen_W = Place(X_WR, screen_R);
  if (viewing.stereo == Stereo::kNone) return {FrustumThrough(screen_W, X_WR * viewing.X_RH.translation)};
  std::vector<Frustum> frusta;
  for (const glm::dvec3& p_REye : EyesOf(viewing.X_RH, viewing.eye_distance_m)) {
    frusta.push_back(FrustumThrough(screen_W, X_WR * p_REye));
  }
  if (viewing.stereo != Stereo::kInterlaced) return frusta;
  // The window's row k is at (k + 1/2) r from its top, r high. Of the left eye's picture, row i is the window's 2 i:
  // its middle is (i + 1/2) 2 r - r/2 from the top, so the picture begins r/2 above the window. The right eye's begins
  // r/2 below. Each has a whole number of rows of 2 r.
  const int num_rows = EyeSize(viewing.stereo, width, height).y;
  double shift = 0.5;
  for (Frustum& frustum : frusta) {
    const double row = (frustum.top - frustum.bottom) / height;
    frustum.top += shift * row;
    frustum.bottom = frustum.top - 2.0 * row * num_rows;
    shift = -shift;
  }
  return frusta;
}

}  // namespace view
