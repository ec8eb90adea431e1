#include "view/conformance/testing/known_scene.hpp"

#include "view/conformance/cast_ids.hpp"
#include "vps/mesh/vertex_normals.hpp"
#include "vps/testing/shapes.hpp"

namespace view {

// A mesh is named by its body's index.
core::Result<vps::VisualMesh> MeshOfBody(const std::filesystem::path& name) {
  const KnownBody body = KnownBodies()[std::stoul(name.string())];
  const vps::TriangleMesh mesh = body.is_ball ? vps::MakeSphere(0.5 * body.size_m.x, 96) : vps::MakeBox(body.size_m);
  return vps::VisualMesh{{vps::SplitAtCreases(mesh, 0.6)}};
}

Scene KnownScene() {
  Scene scene;
  auto assets = std::make_shared<Assets>();
  assets->cameras = {KnownCamera()};
  scene.space.sun_direction_W = glm::normalize(glm::dvec3(0.4, -0.5, 0.8));
  const glm::vec3 colors[] = {
      {0.5f, 0.5f, 0.5f}, {0.7f, 0.2f, 0.1f}, {0.1f, 0.3f, 0.7f}, {0.8f, 0.7f, 0.1f}, {0.2f, 0.6f, 0.2f}};
  std::uint32_t index = 0;
  for (const KnownBody& body : KnownBodies()) {
    assets->meshes.emplace_back(std::to_string(index));
    assets->instance_names.push_back(std::to_string(index));
    Instance instance;
    instance.mesh = index;
    instance.X_WM = body.X_WO;
    instance.material.base_color = colors[index++ % std::size(colors)];
    instance.is_material_given = true;
    scene.instances.push_back(instance);
  }
  scene.assets = assets;
  return scene;
}

}  // namespace view
