#include <array>
#include <map>
#include <set>
#include <utility>

#include "core/messages/physics.hpp"
#include "scene/has_fingers.hpp"
#include "scene/load_scenario.hpp"
#include "scene/read_scenario.hpp"

namespace scene {
namespace {

class ScenarioChecker {
 public:
  ScenarioChecker(const Scenario& scenario, std::vector<Diagnostic>* diagnostics)
      : scenario_(scenario), diagnostics_(diagnostics) {}

  void Check() {
    CheckNames();
    for (const Object& object : scenario_.objects) CheckObject(object);
    for (const Device& device : scenario_.devices) CheckDevice(device);
    for (const Mechanism& mechanism : scenario_.mechanisms) CheckMechanism(mechanism);
    CheckCounts();
    CheckPlace();
  }

 private:
  void Report(const Location& where, std::string what, std::string why, std::string fix) {
    diagnostics_->push_back({where, std::move(what), std::move(why), std::move(fix)});
  }

  // The two directions turn W to the stars, so they must span a plane.
  void CheckPlace() {
    for (const auto& [what, direction] : {std::pair{"sun: direction", scenario_.place.sun_W},
                                          std::pair{"environment: zenith", scenario_.place.zenith_W}}) {
      if (glm::length(direction) > 1e-6) continue;
      Report({scenario_.file, 0}, std::string(what) + " has no length", "it must be a direction in W",
             "write a vector other than 0 0 0");
      return;
    }
    const double sine =
        glm::length(glm::cross(glm::normalize(scenario_.place.sun_W), glm::normalize(scenario_.place.zenith_W)));
    if (sine > 1e-3) return;
    Report({scenario_.file, 0}, "environment: zenith lies along the sun's direction",
           "two directions are needed to turn the scene to the stars", "choose another zenith");
  }

  template <typename T, typename Name>
  void CheckUnique(const char* title, const std::vector<T>& items, const Name& name_of) {
    std::map<std::string, int> first_lines;
    for (const T& item : items) {
      const auto [it, is_new] = first_lines.emplace(name_of(item), item.location.line);
      if (is_new || it->first.empty()) continue;
      Report(item.location, "a second " + std::string(title) + " '" + it->first + "'",
             "the name is taken by line " + std::to_string(it->second), "rename one of them");
    }
  }

  void CheckNames() {
    CheckUnique("object", scenario_.objects, [](const Object& object) { return object.name; });
    CheckUnique("tactile", scenario_.tactiles, [](const Tactile& tactile) { return tactile.name; });
    CheckUnique("mechanism", scenario_.mechanisms, [](const Mechanism& mechanism) { return mechanism.name; });
    CheckUnique("device with the role", scenario_.devices, [](const Device& device) { return device.role; });
  }

  void CheckMesh(const Object& object, const std::filesystem::path& mesh) {
    static const std::set<std::string> kKnown{".obj", ".stl", ".ply", ".off", ".gltf", ".glb"};
    if (mesh.empty() || kKnown.count(mesh.extension().string()) > 0) return;
    Report(object.location,
           "object '" + object.name + "': mesh '" + mesh.filename().string() + "' has an unknown format",
           "meshes are read from OBJ, STL, PLY, OFF, glTF and GLB", "convert the mesh to one of these");
  }

  void CheckObject(const Object& object) {
    const std::string title = "object '" + object.name + "': ";
    CheckMesh(object, object.visual_mesh);
    if (object.collision_mesh != object.visual_mesh) CheckMesh(object, object.collision_mesh);
    if (object.owner == Owner::kPhysics) {
      if (object.visual_mesh.empty() && object.collision_mesh.empty() && !object.inertia) {
        Report(object.location, title + "no mesh", "its inertia follows from the mesh", "add <visual mesh=\"...\"/>");
      }
    }
    if (object.voxel_size_m != 0.0 &&
        (object.voxel_size_m < kMinVoxelSize_m || object.voxel_size_m > kMaxVoxelSize_m)) {
      Report(object.location, title + "voxel_size_m is " + std::to_string(object.voxel_size_m),
             "it must lie between 0.02 mm and 100 mm", "write the size in metres, a quarter of the clearance or less");
    }
    if (object.num_points != 0 && (object.num_points < kMinPoints || object.num_points > kMaxPoints)) {
      Report(object.location, title + std::to_string(object.num_points) + " points", "a pointshell has 16 to 4,000,000",
             "write points=\"16384\", more for larger parts");
    }
  }

  void CheckDevice(const Device& device) {
    const std::string title = "device '" + device.role + "': ";
    if (device.palm < 0) {
      Report(device.location, title + "no palm", "a hand is a palm, with two jaws or none",
             "add an <object owner=\"hand\" part=\"palm\" role=\"" + device.role + "\">");
    }
    if ((device.jaw_left < 0) != (device.jaw_right < 0)) {
      const std::string part = device.jaw_left < 0 ? "jaw_left" : "jaw_right";
      Report(
          device.location, title + part + " is missing", "a gripper has two jaws",
          "add an <object owner=\"hand\" part=\"" + part + "\" role=\"" + device.role + "\">, or remove the other jaw");
    }
    if (device.jaw_left >= 0 && HasFingers(scenario_, static_cast<int>(&device - scenario_.devices.data()))) {
      Report(device.location, title + "has jaws and fingers", "a hand grips with the one or the other",
             "remove the jaws, or <fingers role=\"" + device.role + "\">");
    }
    const bool is_simulated = device.type.rfind("simulated_", 0) == 0 || device.type == "hug";
    if (is_simulated != device.address.empty()) {
      Report(
          device.location, title + "type " + device.type + (is_simulated ? " has an address" : " without address"),
          is_simulated ? "a simulated device is nowhere" : "the bridge would not know where the device is",
          is_simulated ? "remove address" : "write address=\"...\": docs/howto/own-device.md says what for each type");
    }
    if (device.opening_start_m > device.opening_max_m) {
      Report(device.location, title + "opening_start_m is above opening_max_m", "the jaws cannot open that far",
             "lower opening_start_m or raise opening_max_m");
    }
  }

  [[nodiscard]] const Object* At(int index) const {
    return index < 0 ? nullptr : &scenario_.objects[static_cast<std::size_t>(index)];
  }

  void CheckMechanism(const Mechanism& mechanism) {
    const std::string title = "mechanism '" + mechanism.name + "': ";
    const Object* parent = At(mechanism.parent);
    const Object* child = At(mechanism.child);
    if (child == nullptr) return;  // reported when it was read
    if (parent == child) {
      Report(mechanism.location, title + "parent and child are both '" + child->name + "'",
             "a mechanism joins two bodies", "name another parent");
      return;
    }
    if (child->owner != Owner::kPhysics) {
      Report(mechanism.location, title + "child '" + child->name + "' is not moved by physics",
             "the mechanism's forces act on an object with owner=\"physics\"",
             "write owner=\"physics\" on it, or swap parent and child");
    }
    if (parent != nullptr && parent->owner == Owner::kHand && mechanism.finger_role < 0) {
      Report(mechanism.location, title + "parent '" + parent->name + "' is a part of a hand",
             "hands hold objects by grasping only, and have no joints but those of <fingers>", "name another parent");
    }
    if (mechanism.kind == MechanismKind::kSnap && mechanism.release_force_N <= 0.0) {
      Report(mechanism.location, title + "release_force_N is zero", "such a snap holds nothing",
             "write the axial force in newton at which it releases");
    }
    if (mechanism.kind == MechanismKind::kSnap && mechanism.stiffness_N_per_m <= 0.0) {
      Report(mechanism.location, title + "stiffness_N_per_m is zero", "such a snap neither guides nor holds the child",
             "write the stiffness in N/m, 2000 to 20000 is usual");
    }
  }

  void CheckCounts() {
    std::size_t num_bodies = 0;
    for (const Object& object : scenario_.objects) num_bodies += object.owner == Owner::kPhysics ? 1 : 0;
    CheckCount("objects that physics moves", num_bodies, core::kMaxBodies);
    CheckCount("mechanisms", scenario_.mechanisms.size(), core::kMaxMechanisms);
    CheckCount("devices", scenario_.devices.size(), kMaxDevices);
    CheckCount("objects", scenario_.objects.size(), core::kNoObject);
  }

  void CheckCount(const char* what, std::size_t count, std::size_t limit) {
    if (count <= limit) return;
    Report({scenario_.file, 0}, std::to_string(count) + " " + what, "messages have room for " + std::to_string(limit),
           "use fewer");
  }

  const Scenario& scenario_;
  std::vector<Diagnostic>* diagnostics_;
};

}  // namespace

void CheckScenario(const Scenario& scenario, std::vector<Diagnostic>* diagnostics) {
  ScenarioChecker(scenario, diagnostics).Check();
}

}  // namespace scene
