#pragma once

#include <array>
#include <glm/glm.hpp>

#include "raytrace/rays.hpp"
#include "raytrace/shade.hpp"
#include "raytrace/world.hpp"
#include "tiles/quality.hpp"

namespace raytrace {

// The light that comes back along rays that have met what they meet: the sun where nothing is before it, mirror images,
// what is seen through glass, the light around. `spread`: how much wider a pixel is per metre.
class Shading {
 public:
  Shading(const World& world, const Lighting& lighting, float spread, const tiles::Quality& quality)
      : world_(world), lighting_(lighting), spread_(spread), quality_(quality) {}

  // Rays from the eye through the square of pixels whose left upper one is (x, y).
  void FollowFromEye(const Rays& rays, int x, int y, glm::vec3* light) const;

 private:
  // What a packet of rays has met.
  struct Hits {
    std::array<Surface, kLanes> surfaces;
    std::array<Lighting::Parts, kLanes> parts;
    std::array<float, kLanes> far_m{};  // from the eye, along the rays
  };
  // Where rays of the eye are in the picture; null: they have been mirrored or bent.
  struct Square {
    int x = 0, y = 0;
  };
  using Far = std::array<float, kLanes>;

  void Follow(const Rays& rays, const Far& far_m, int depth, const Square* square, glm::vec3* light) const;
  void AddSun(const Rays& rays, const Hits& hits, const Square* square, glm::vec3* light) const;
  void AddSurroundings(const Rays& rays, const Hits& hits, const Square* square, glm::vec3* light) const;
  void AddMirrored(const Rays& rays, const Hits& hits, int depth, glm::vec3* light) const;
  void AddThrough(const Rays& rays, const Hits& hits, int depth, glm::vec3* light) const;

  const World& world_;
  const Lighting& lighting_;
  float spread_;
  tiles::Quality quality_;
};

}  // namespace raytrace
