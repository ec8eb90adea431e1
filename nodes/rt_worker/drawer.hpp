#pragma once

#include <memory>
#include <vector>

#include "core/messages/rays.hpp"
#include "core/result.hpp"
#include "raytrace/tracer.hpp"
#include "scene/scenario.hpp"
#include "tiles/frame.hpp"
#include "view/scene.hpp"

namespace rt_worker {

// Draws tiles of frames. The meshes are loaded once; a frame says where things are.
class Drawer {
 public:
  // Errors name the file.
  static core::Result<Drawer> Create(const view::Scene& scene, const raytrace::MeshLoader& load_mesh);

  // Answers a job of that frame. False: the frame is of another scenario, or the tile is not in it.
  bool Draw(const core::RayFrame& frame, const core::RayJob& job, core::RayTile* answer);

 private:
  void DrawParts(const tiles::Tile& tile, const tiles::Quality& quality);

  view::Scene scene_;
  std::unique_ptr<raytrace::Tracer> tracer_;
  std::uint64_t frame_ = 0;  // where things are
  bool has_frame_ = false;
  std::vector<tiles::SeenPart> parts_;  // of that frame
  std::vector<float> light_, depth_m_;  // of a tile
};

}  // namespace rt_worker
