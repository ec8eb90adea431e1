#pragma once

#include <filesystem>
#include <mutex>
#include <stdexcept>

#include "core/result.hpp"
#include "scene/scenario.hpp"
#include "tools/failures/variant.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace failures {

// Where this process puts meshes and cooked structures; removed at its end.
const std::filesystem::path& WorkFolder();

// Writes the mesh once and returns its file.
std::filesystem::path MeshFile(const vps::TriangleMesh& mesh);

// Held while a scene is set up: cooked structures and scripts of this process share files.
class SetUpLock {
 public:
  SetUpLock();

 private:
  std::unique_lock<std::recursive_mutex> lock_;
};

// A setup error of a test scene is an error of the program.
template <typename T>
T Must(core::Result<T> result) {
  if (!result) throw std::runtime_error(result.error().detail);
  return std::move(*result);
}

// A scenario made by a program. Hands have no jaws; only the first has an operator.
class SceneKit {
 public:
  explicit SceneKit(const Variant& variant);

  // Objects with a field, with points, or with both; 0: without.
  std::uint16_t AddFixed(const vps::TriangleMesh& mesh, const core::Pose& X_WO, double voxel_m,
                         std::uint32_t num_points = 0);
  std::uint16_t AddBody(const vps::TriangleMesh& mesh, const core::Pose& X_WO, double mass_kg, double voxel_m,
                        std::uint32_t num_points);
  // A tool: the palm of a hand. It has points.
  std::uint16_t AddHand(const vps::TriangleMesh& mesh, const core::Pose& X_WD, std::uint32_t num_points);
  // A hand far away that touches nothing: without one, haptic_node's contacts do not reach physics_node.
  void AddIdleHand();
  scene::Pair& AddPair(std::uint16_t sampled, std::uint16_t field);
  scene::Device& device() { return scenario.devices[0]; }

  scene::Scenario scenario;

 private:
  std::uint16_t Add(const vps::TriangleMesh& mesh, scene::Owner owner, const core::Pose& X_WO, double voxel_m,
                    std::uint32_t num_points);
};

}  // namespace failures
