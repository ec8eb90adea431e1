#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "space/stars/star.hpp"

namespace space {

// A pinhole camera at the origin. V: x right, y up, looking along -z.
struct StarCamera {
  glm::dmat3 R_VC{1.0};
  double focal_px = 1.0;  // across
  int width = 0;
  int height = 0;
  double focal_ratio = 1.0;      // focal length up over that across; 1: square pixels
  glm::dvec2 axis_px{0.0, 0.0};  // where V's axis is in the picture, from its middle, to the right and up

  bool operator==(const StarCamera&) const = default;
};

// Stars ready to be drawn: in cells of the sky, so that those out of view cost nothing.
class StarField {
 public:
  explicit StarField(std::span<const Star> stars);

  // Adds the luminance [cd/m2] of each star in view to an image of four floats (linear RGB, unused) for each pixel, the
  // lowest row first: the star's illuminance over the pixel's solid angle. It is shared between the four pixels whose
  // centres surround the star, so that its centroid is its place. Returns how many stars were drawn.
  std::size_t AddTo(const StarCamera& camera, std::span<glm::vec4> image) const;

  [[nodiscard]] std::size_t num_stars() const { return x_.size(); }

 private:
  struct Cell {
    glm::vec3 centre_C{0.0f};
    float radius_rad = 0.0f;
    std::size_t first = 0;
    std::size_t last = 0;
  };

  std::vector<float> x_, y_, z_;           // direction in C
  std::vector<glm::vec3> illuminance_lx_;  // linear RGB
  std::vector<Cell> cells_;
};

}  // namespace space
