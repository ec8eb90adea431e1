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

std::string Scenario::PairName(std::size_t pair_index) const {
  const Pair& pair = pairs.at(pair_index);
  return objects.at(pair.sampled).name + "/" + objects.at(pair.field).name;
}

const char* Scenario::PairSource(std::size_t pair_index) const {
  return pairs.at(pair_index).owner == PairOwner::kPhysics ? "physics_node" : "haptic_node";
}

core::Pose PartPose(HandPart part, const core::Pose& X_WPalm, double opening_m) {
  double x_m = 0.0;
  if (part == HandPart::kJawLeft) x_m = -0.5 * opening_m;
  if (part == HandPart::kJawRight) x_m = 0.5 * opening_m;
  return X_WPalm * core::Pose{glm::dquat(1.0, 0.0, 0.0, 0.0), glm::dvec3(x_m, 0.0, 0.0)};
}

}  // namespace scene
