#pragma once

#include <filesystem>
#include <functional>
#include <future>
#include <vector>

#include "core/result.hpp"
#include "nodes/visual_node/draw/surface_painter.hpp"
#include "nodes/visual_node/gl/mesh_store.hpp"
#include "nodes/visual_node/sky/sky.hpp"
#include "vps/mesh/load_mesh.hpp"

namespace visual_node {

using MeshLoader = std::function<core::Result<vps::VisualMesh>(const std::filesystem::path&)>;

// What a renderer needs that takes long and no OpenGL.
struct Ingredients {
  core::Result<std::vector<MeshData>> meshes;  // index: Assets::meshes; of an empty path: an empty mesh
  core::Result<SkyData> sky;
  SurfaceTables surfaces;
};
Ingredients MakeIngredients(const std::vector<std::filesystem::path>& meshes, const MeshLoader& load_mesh);

// Makes them in threads, so that opening a window, compiling shaders and joining a session do not wait for them.
class IngredientsInWork {
 public:
  explicit IngredientsInWork(std::vector<std::filesystem::path> meshes);
  // Waits for them. Once.
  Ingredients Take();

 private:
  struct Tables {
    core::Result<SkyData> sky;
    SurfaceTables surfaces;
  };
  std::future<core::Result<std::vector<MeshData>>> meshes_;
  std::future<Tables> tables_;
};

}  // namespace visual_node
