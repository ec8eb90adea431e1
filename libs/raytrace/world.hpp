#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "core/result.hpp"
#include "raytrace/shade.hpp"
#include "raytrace/texture.hpp"
#include "view/scene.hpp"
#include "vps/mesh/load_mesh.hpp"

struct RTCDeviceTy;
struct RTCSceneTy;
struct RTCGeometryTy;

namespace raytrace {

using MeshLoader = std::function<core::Result<vps::VisualMesh>(const std::filesystem::path&)>;

// Which instances a ray meets.
constexpr unsigned kDrawn = 1;    // those with a surface of their own: visible and not transparent
constexpr unsigned kVisible = 2;  // transparent ones, too
constexpr unsigned kBlocks = 4;   // those drawn, but for glass: what keeps light away

// What rays can meet: a tree of triangles for each mesh and each sheet, and a tree of the instances above them. An
// instance that moves changes only the upper one.
class World {
 public:
  static core::Result<std::unique_ptr<World>> Create(const view::Scene& scene, const MeshLoader& load_mesh);
  World(const World&) = delete;
  World& operator=(const World&) = delete;
  ~World();

  // Places instances and bends sheets. No ray is on its way meanwhile.
  void Update(const view::Scene& scene);

  // Where a ray of Embree ended: its identifiers and barycentric coordinates, what it came along (not of unit length),
  // and how wide a pixel is there [m].
  struct Place {
    unsigned instance = 0;
    unsigned primitive = 0;
    unsigned triangle = 0;
    float u = 0.0f;
    float v = 0.0f;
    glm::vec3 along_W{0.0f};
    float pixel_m = 0.0f;
  };
  [[nodiscard]] Surface SurfaceAt(const Place& place) const;

  [[nodiscard]] RTCSceneTy* tree() const { return top_; }
  // The object's index + 1, also for a sheet that belongs to it.
  [[nodiscard]] std::uint16_t IdOf(unsigned instance) const { return ids_[instance]; }
  [[nodiscard]] std::vector<Lamp> ShiningLamps(const view::Scene& scene) const;
  // How often a tree of triangles was made or bent.
  [[nodiscard]] int num_mesh_builds() const { return num_mesh_builds_; }

 private:
  struct Mesh {
    vps::VisualMesh source;  // as it is bent now
    vps::VisualMesh skin;    // before it was bent by its joints; rigid: empty
    view::Posture posture;
    std::vector<Texture> textures;
    std::vector<glm::vec3> rest_positions, rest_normals;  // of a sheet before it bent
    RTCSceneTy* tree = nullptr;
    bool has_lens = false;
    glm::vec3 centre_M{0.0f};
    float radius_m = 0.0f;
  };
  struct Placed {
    std::size_t mesh = 0;
    core::Pose X_WM;
    glm::mat3 R_WM{1.0f};
    glm::vec3 p_WM{0.0f};
    unsigned mask = 0;
    RTCGeometryTy* geometry = nullptr;
    std::string variant;
    std::vector<view::Material> materials;  // of the mesh's primitives
    bool has_own_material = false;          // instead of the mesh file's
  };

  static constexpr std::size_t kMaxLamps = 4;  // as in OpenGL

  World();
  core::Result<void> Grow(const view::Scene& scene, const MeshLoader& load_mesh);
  void Add(vps::VisualMesh source, bool bends);
  void Move(Placed* placed, const core::Pose& X_WM, unsigned mask);
  void Bend(const view::Sheet& sheet, Placed* placed);
  void Bend(const view::Posture& posture, Placed* placed);
  void Refit(Placed* placed);
  void Wrinkle(const Placed& placed, const vps::VisualPrimitive& part, const std::uint32_t* corner, const float* shares,
               float pixel_m, Surface* surface) const;

  RTCDeviceTy* device_ = nullptr;
  RTCSceneTy* top_ = nullptr;
  std::vector<Mesh> meshes_;    // of Assets::meshes, then one for each sheet
  std::vector<Placed> placed_;  // Scene::instances, then Scene::sheets
  std::vector<std::uint16_t> ids_;
  std::vector<std::uint64_t> sheet_versions_;
  std::size_t num_instances_ = 0;
  Texture wrinkles_;
  bool has_changed_ = false;
  int num_mesh_builds_ = 0;
};

}  // namespace raytrace
