#include "tools/failures/gripper.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kOpen_m = 0.01;  // farther than closed
constexpr int kClosing_ticks = 200;
constexpr int kSettling_ticks = 500;

}  // namespace

vps::TriangleMesh MakeBoxAt(const glm::dvec3& size_m, const glm::dvec3& centre_m) {
  vps::TriangleMesh mesh = vps::MakeBox(size_m);
  for (glm::dvec3& vertex : mesh.vertices) vertex += centre_m;
  return mesh;
}

void AddGripper(SceneKit* kit, const core::Pose& X_WD, double width_m) {
  kit->AddHand(MakeBoxAt({0.06, 0.03, 0.02}, {0.0, 0.0, 0.015}), X_WD, 500);
  scene::Device& device = kit->device();
  device.opening_max_m = 0.1;
  device.opening_start_m = width_m + kOpen_m;
  for (const scene::HandPart part : {scene::HandPart::kJawLeft, scene::HandPart::kJawRight}) {
    const bool is_left = part == scene::HandPart::kJawLeft;
    const auto mesh = MakeBoxAt({0.01, 0.02, 0.03}, {is_left ? -0.005 : 0.005, 0.0, -0.02});
    const auto jaw = kit->AddFixed(mesh, scene::PartPose(part, X_WD, device.opening_start_m), 0.0, 2000);
    scene::Object& object = kit->scenario.objects[jaw];
    object.owner = scene::Owner::kHand;
    object.part = part;
    object.role = 0;
    (is_left ? device.jaw_left : device.jaw_right) = jaw;
  }
}

void AddGripPairs(SceneKit* kit, std::uint16_t object) {
  for (const int part : {kit->device().palm, kit->device().jaw_left, kit->device().jaw_right}) {
    kit->AddPair(static_cast<std::uint16_t>(part), object);
  }
}

std::uint16_t AddHeldBox(SceneKit* kit, const core::Pose& X_WD, const glm::dvec3& size_m, double mass_kg,
                         double voxel_m, std::uint32_t num_points) {
  AddGripper(kit, X_WD, size_m.x);
  const auto mesh = MakeBoxAt(size_m, {0.0, 0.0, kHeldTop_m - 0.5 * size_m.z});
  const auto box = kit->AddBody(mesh, X_WD, mass_kg, voxel_m, num_points);
  AddGripPairs(kit, box);
  return box;
}

void Grip(Loop* loop, const core::Pose& X_WD, double width_m, double squeeze_m) {
  for (int i = 0; i <= kClosing_ticks + kSettling_ticks; ++i) {
    const double open = std::max(0.0, 1.0 - static_cast<double>(i) / kClosing_ticks);
    loop->SetOpening(width_m + open * kOpen_m - (1.0 - open) * 2.0 * squeeze_m);
    loop->Tick(X_WD);
  }
  if (!loop->is_holding()) throw std::runtime_error("the gripper holds nothing");
}

double Spread(const std::vector<glm::dvec3>& values) {
  const double share = 1.0 / static_cast<double>(values.size());
  glm::dvec3 mean(0.0);
  for (const glm::dvec3& v : values) mean += share * v;
  double squares = 0.0;
  for (const glm::dvec3& v : values) squares += share * glm::dot(v - mean, v - mean);
  return std::sqrt(squares);
}

}  // namespace failures
