#pragma once

#include <cstdint>
#include <vector>

#include "core/pose.hpp"
#include "picture/measured.hpp"
#include "scene/scenario.hpp"

namespace view {

// A body whose silhouette is known exactly: a box of this size, or a ball of this diameter along x.
struct KnownBody {
  bool is_ball = false;
  glm::dvec3 size_m{0.2};
  core::Pose X_WO;
};

// Bodies that hide parts of each other, turned and not, near and far.
std::vector<KnownBody> KnownBodies();
scene::Camera KnownCamera();

// Which body the ray through each pixel's centre meets first: its index + 1; 0: none. `camera` is in W.
picture::Measured<std::uint16_t> CastIds(const std::vector<KnownBody>& bodies, const scene::Camera& camera, int width,
                                         int height);

}  // namespace view
