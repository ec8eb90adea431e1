#pragma once

#include <cstdint>
#include <filesystem>

#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/gl/gl_objects.hpp"
#include "picture/measured.hpp"

namespace visual_node {

// Which object is seen at a pixel's centre, and how far away it is. Arrows, texts and the sky are no objects.
struct ObjectPicture {
  picture::Measured<std::uint16_t> ids;  // index of the instance + 1; 0: nothing
  picture::Measured<float> depth_m;      // along the viewing direction, not along the pixel's ray; 0: nothing
};

// Draws object ids and depths beside the renderer's picture, with its meshes and clip planes.
class ObjectPass {
 public:
  // Error: kUnsupported, when the driver cannot compile the shader.
  static core::Result<ObjectPass> Create();

  // `renderer` has drawn this scene before: its sheets are used as they were drawn.
  [[nodiscard]] ObjectPicture Draw(const Renderer& renderer, const view::Scene& scene, const scene::Camera& given,
                                   int width, int height) const;
  [[nodiscard]] ObjectPicture Draw(const Renderer& renderer, const view::Scene& scene, const view::Frustum& eye,
                                   int width, int height) const;

 private:
  ObjectPass() = default;
  GlProgram program_;
};

// Depths as 16 bits in millimetres, what programs that read depth cameras expect: up to 65.535 m; 0: nothing.
picture::Measured<std::uint16_t> ToMillimetres(const picture::Measured<float>& depth_m);

// The names of the ids in `ids` as JSON: {"0": null, "1": "satellite", ...}, all objects of the scene. Error: kIo.
core::Result<void> WriteIdNames(const view::Assets& assets, const std::filesystem::path& file);

}  // namespace visual_node
