#include "nodes/visual_node/draw/ingredients.hpp"

#include <utility>

namespace visual_node {
namespace {

core::Result<std::vector<MeshData>> LoadMeshes(const std::vector<std::filesystem::path>& files,
                                               const MeshLoader& load_mesh) {
  std::vector<MeshData> meshes;
  for (const std::filesystem::path& file : files) {
    core::Result<vps::VisualMesh> mesh;
    if (!file.empty()) mesh = load_mesh(file);
    if (!mesh) return tl::unexpected(mesh.error());
    meshes.push_back(MeshData::Of(std::move(*mesh)));
  }
  return meshes;
}

}  // namespace

Ingredients MakeIngredients(const std::vector<std::filesystem::path>& meshes, const MeshLoader& load_mesh) {
  return {LoadMeshes(meshes, load_mesh), SkyData::Make(), SurfaceTables::Make()};
}

IngredientsInWork::IngredientsInWork(std::vector<std::filesystem::path> meshes)
    : meshes_(std::async(std::launch::async,
                         [meshes = std::move(meshes)] {
                           return LoadMeshes(meshes, [](const auto& file) { return vps::LoadVisualMesh(file); });
                         })),
      tables_(std::async(std::launch::async, [] {
        return Tables{SkyData::Make(), SurfaceTables::Make()};
      })) {}

Ingredients IngredientsInWork::Take() {
  auto meshes = meshes_.get();
  Tables tables = tables_.get();
  return {std::move(meshes), std::move(tables.sky), std::move(tables.surfaces)};
}

}  // namespace visual_node
