#pragma once

#include <memory>

#include "core/result.hpp"
#include "picture/measured.hpp"
#include "raytrace/world.hpp"
#include "tiles/quality.hpp"
#include "tiles/tile.hpp"
#include "view/frustum.hpp"
#include "view/scene.hpp"

namespace raytrace {

// What an eye sees, and the size of its picture.
struct Eye {
  glm::vec3 p_W{0.0f};
  glm::mat3 R_WE{1.0f};  // E looks along -z with y up
  // The picture's edges at the distance 1, as view::Frustum's.
  float left = -1.0f, right = 1.0f, bottom = -1.0f, top = 1.0f;
  int width = 0;
  int height = 0;

  static Eye Of(const view::Frustum& frustum, int width, int height);
  // `placed` is in W (view::PlaceCamera).
  static Eye Of(const scene::Camera& placed, int width, int height);

  // How wide and how high a pixel is at the distance 1.
  [[nodiscard]] glm::vec2 pixel() const {
    return {(right - left) / static_cast<float>(width), (top - bottom) / static_cast<float>(height)};
  }
};

using tiles::Tile;

// What is drawn of a tile. Light is linear RGB, in the unit of view::EnvironmentLight. Depths are along the viewing
// direction [m]; 0: nothing is there, and the light is none.
struct LitTile {
  Tile at;
  picture::Measured<float> light;
  picture::Measured<float> depth_m;
};

// As visual_node's: index of the instance + 1; 0: nothing. Transparent instances count.
struct ObjectTile {
  picture::Measured<std::uint16_t> ids;
  picture::Measured<float> depth_m;
};

// Draws a view::Scene by following rays from the eye: what they meet first, whether the sun is seen from there, and
// what a smooth surface mirrors. Draw and FindObjects may be called by several threads at once, Update by none
// meanwhile.
class Tracer {
 public:
  // Clip planes as in OpenGL.
  static constexpr float kNear_m = 0.01f;
  static constexpr float kFar_m = 60.0f;

  // Loads every mesh of the scene's assets. Errors name the file.
  static core::Result<std::unique_ptr<Tracer>> Create(const view::Scene& scene, const MeshLoader& load_mesh);

  // From the next tile on: things are where this scene has them, in this light.
  void Update(const view::Scene& scene, const view::EnvironmentLight& light);

  // With no mirror images surfaces mirror only the light around, as in OpenGL.
  [[nodiscard]] LitTile Draw(const Eye& eye, const Tile& tile, const tiles::Quality& quality = {}) const;
  [[nodiscard]] ObjectTile FindObjects(const Eye& eye, const Tile& tile) const;

  [[nodiscard]] const World& world() const { return *world_; }

 private:
  Tracer() = default;

  std::unique_ptr<World> world_;
  Lighting lighting_;
};

}  // namespace raytrace
