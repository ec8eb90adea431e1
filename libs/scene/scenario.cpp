#include "scene/scenario.hpp"

#include <algorithm>

namespace scene {
namespace {

// Position of the first element that `matches`; -1: none.
template <typename T, typename Matches>
int IndexOf(const std::vector<T>& items, const Matches& matches) {
  const auto it = std::find_if(items.begin(), items.end(), matches);
  return it == items.end() ? -1 : static_cast<int>(it - items.begin());
}

}  // namespace

int Scenario::FindObject(const std::string& object_name) const {
  return IndexOf(objects, [&](const Object& object) { return object.name == object_name; });
}

int Scenario::FindMechanism(const std::string& mechanism_name) const {
  return IndexOf(mechanisms, [&](const Mechanism& mechanism) { return mechanism.name == mechanism_name; });
}

int Scenario::FindRole(const std::string& role) const {
  return IndexOf(devices, [&](const Device& device) { return device.role == role; });
}

int Scenario::FindTactile(const std::string& tactile) const {
  return IndexOf(tactiles, [&](const Tactile& other) { return other.name == tactile; });
}

std::string Scenario::PairName(std::size_t pair_index) const {
  const Pair& pair = pairs.at(pair_index);
  return objects.at(pair.sampled).name + "/" + objects.at(pair.field).name;
}

const char* Scenario::PairSource(std::size_t pair_index) const {
  return pairs.at(pair_index).owner == PairOwner::kPhysics ? "physics_node" : "haptic_node";
}

std::vector<const char*> LiveFigures(const Mechanism& mechanism) {
  switch (mechanism.kind) {
    case MechanismKind::kHinge:
      if (mechanism.detents_rad.empty()) return {"damping", "locked", "motor_rad_per_s", "motor_torque_Nm"};
      return {"damping", "locked", "motor_rad_per_s", "motor_torque_Nm", "detent_torque_Nm"};
    case MechanismKind::kSlider:
      return {"damping", "locked", "motor_m_per_s", "motor_force_N"};
    case MechanismKind::kSnap:
      return {"engage_force_N", "release_force_N", "stiffness_N_per_m", "stiffness_Nm_per_rad", "damping"};
    case MechanismKind::kHookAndLoop:
      return {"release_force_N", "stiffness_N_per_m", "damping"};
  }
  return {};
}

core::Pose PartPose(HandPart part, const core::Pose& X_WPalm, double opening_m) {
  double x_m = 0.0;
  if (part == HandPart::kJawLeft) x_m = -0.5 * opening_m;
  if (part == HandPart::kJawRight) x_m = 0.5 * opening_m;
  return X_WPalm * core::Pose{glm::dquat(1.0, 0.0, 0.0, 0.0), glm::dvec3(x_m, 0.0, 0.0)};
}

}  // namespace scene
