#include "tools/failures/scene_kit.hpp"

#include <unistd.h>

#include <cstdio>
#include <fstream>

#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

class Folder {
 public:
  Folder() : path_(std::filesystem::temp_directory_path() / ("vr_oos_failures_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::string ToObj(const vps::TriangleMesh& mesh) {
  std::string text;
  char line[120];
  for (const glm::dvec3& v : mesh.vertices) {
    std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", v.x, v.y, v.z);
    text += line;
  }
  for (const auto& t : mesh.triangles) {
    std::snprintf(line, sizeof line, "f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1);
    text += line;
  }
  return text;
}

}  // namespace

const std::filesystem::path& WorkFolder() {
  static const Folder folder;
  return folder.path();
}

SetUpLock::SetUpLock() {
  static std::recursive_mutex mutex;
  lock_ = std::unique_lock(mutex);
}

std::filesystem::path MeshFile(const vps::TriangleMesh& mesh) {
  const SetUpLock lock;
  const std::string text = ToObj(mesh);
  const std::filesystem::path file = WorkFolder() / (std::to_string(std::hash<std::string>{}(text)) + ".obj");
  if (!std::filesystem::exists(file)) std::ofstream(file) << text;
  return file;
}

SceneKit::SceneKit(const Variant& variant) {
  scenario.name = "failure";
  scenario.method = variant.method;
  scenario.coupling.type = variant.coupling;
}

std::uint16_t SceneKit::Add(const vps::TriangleMesh& mesh, scene::Owner owner, const core::Pose& X_WO, double voxel_m,
                            std::uint32_t num_points) {
  scene::Object object;
  object.name = "object" + std::to_string(scenario.objects.size());
  object.owner = owner;
  object.visual_mesh = object.collision_mesh = MeshFile(mesh);
  object.X_WO = X_WO;
  object.voxel_size_m = voxel_m;
  object.num_points = num_points;
  scenario.objects.push_back(object);
  return static_cast<std::uint16_t>(scenario.objects.size() - 1);
}

std::uint16_t SceneKit::AddFixed(const vps::TriangleMesh& mesh, const core::Pose& X_WO, double voxel_m,
                                 std::uint32_t num_points) {
  return Add(mesh, scene::Owner::kFixed, X_WO, voxel_m, num_points);
}

std::uint16_t SceneKit::AddBody(const vps::TriangleMesh& mesh, const core::Pose& X_WO, double mass_kg, double voxel_m,
                                std::uint32_t num_points) {
  const std::uint16_t body = Add(mesh, scene::Owner::kPhysics, X_WO, voxel_m, num_points);
  scenario.objects[body].mass_kg = mass_kg;
  return body;
}

std::uint16_t SceneKit::AddHand(const vps::TriangleMesh& mesh, const core::Pose& X_WD, std::uint32_t num_points) {
  const std::uint16_t palm = Add(mesh, scene::Owner::kHand, X_WD, 0.0, num_points);
  scenario.objects[palm].part = scene::HandPart::kPalm;
  scenario.objects[palm].role = static_cast<int>(scenario.devices.size());
  scene::Device device;
  device.role = scenario.devices.empty() ? "right" : "left";
  device.palm = palm;
  device.X_WD_start = X_WD;
  device.opening_max_m = 0.0;
  device.opening_start_m = 0.0;
  scenario.devices.push_back(device);
  return palm;
}

void SceneKit::AddIdleHand() {
  AddHand(vps::MakeBox(glm::dvec3(0.02)), {{1, 0, 0, 0}, {0, 0, 5.0}}, 100);
}

scene::Pair& SceneKit::AddPair(std::uint16_t sampled, std::uint16_t field) {
  scene::Pair pair;
  pair.sampled = sampled;
  pair.field = field;
  scenario.pairs.push_back(pair);
  return scenario.pairs.back();
}

}  // namespace failures
