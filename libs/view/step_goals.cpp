#include "view/step_goals.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <regex>

#include "scene/xml.hpp"

namespace view {
namespace {

constexpr glm::vec3 kPlannedColor{0.35f, 0.65f, 1.0f};
constexpr double kReached_m = 0.002;       // nearer than this a part is where it belongs; by eye
constexpr double kLeastApproach_m = 0.03;  // of a socket without a guide; by eye

void TakeGoals(const scene::Scenario& scenario, const std::string& condition, std::vector<StepGoal>* goals) {
  static const std::regex kSnap(R"(([A-Za-z_]\w*)\.state\s*==\s*1)");
  static const std::regex kGrasp(R"(([A-Za-z_][\w/]*)\.grasped\.([A-Za-z_]\w*)\s*==\s*1)");
  const std::sregex_iterator end;
  for (std::sregex_iterator it(condition.begin(), condition.end(), kSnap); it != end; ++it) {
    const int mechanism = scenario.FindMechanism((*it)[1]);
    if (mechanism < 0) continue;
    const scene::Mechanism& found = scenario.mechanisms[static_cast<std::size_t>(mechanism)];
    if (found.kind == scene::MechanismKind::kSnap && found.child >= 0) goals->push_back({.mechanism = mechanism});
  }
  for (std::sregex_iterator it(condition.begin(), condition.end(), kGrasp); it != end; ++it) {
    const int role = scenario.FindRole((*it)[1]), object = scenario.FindObject((*it)[2]);
    if (role < 0 || object < 0) continue;
    const int palm = scenario.devices[static_cast<std::size_t>(role)].palm;
    if (palm >= 0) goals->push_back({.palm = palm, .object = object});
  }
}

void TakeTransitions(const scene::Scenario& scenario, const scene::XmlElement& state, std::vector<StepGoal>* goals) {
  for (const scene::XmlElement& child : state.children) {
    if (child.name == "transition") TakeGoals(scenario, child.Get("cond"), goals);
    TakeTransitions(scenario, child, goals);
  }
}

const scene::XmlElement* FindId(const scene::XmlElement& element, const std::string& id) {
  if (element.Get("id") == id) return &element;
  for (const scene::XmlElement& child : element.children) {
    if (const scene::XmlElement* found = FindId(child, id)) return found;
  }
  return nullptr;
}

void AddWay(const std::vector<glm::vec3>& p_W, Scene* scene) {
  scene->lines.push_back({std::make_shared<const std::vector<glm::vec3>>(p_W), kPlannedColor, 2.5f});
}

void AddWayToSocket(const scene::Mechanism& snap, Scene* scene) {
  const auto child = static_cast<std::size_t>(snap.child);
  const core::Pose X_WP =
      snap.parent >= 0 ? scene->instances[static_cast<std::size_t>(snap.parent)].X_WM : core::Pose{};
  const core::Pose X_WSeat = X_WP * snap.X_PJ;
  const core::Pose X_WPlug = scene->instances[child].X_WM * snap.X_CJ;
  if (glm::distance(X_WSeat.translation, X_WPlug.translation) < kReached_m) return;
  const double approach_m = std::max(snap.guide_length_m, kLeastApproach_m);
  const glm::dvec3 p_SeatPlug = X_WSeat.inverse() * X_WPlug.translation;
  std::vector<glm::vec3> way{glm::vec3(X_WPlug.translation)};
  const bool is_in_guide =
      p_SeatPlug.z < approach_m && std::hypot(p_SeatPlug.x, p_SeatPlug.y) < snap.lateral_tolerance_m;
  if (!is_in_guide) way.emplace_back(X_WSeat * glm::dvec3(0.0, 0.0, approach_m));
  way.emplace_back(X_WSeat.translation);
  AddWay(way, scene);
  if (scene->instances[child].is_visible) {
    scene->phantoms.push_back({static_cast<std::uint32_t>(child), X_WSeat * snap.X_CJ.inverse(), kPlannedColor, 0.3f});
  }
}

}  // namespace

std::map<std::string, std::vector<StepGoal>> ReadStepGoals(const scene::Scenario& scenario) {
  std::map<std::string, std::vector<StepGoal>> goals;
  if (scenario.procedure.empty()) return goals;
  const auto root = scene::ReadXml(scenario.procedure);
  const scene::XmlElement* const procedure = root ? FindId(*root, "procedure") : nullptr;
  if (procedure == nullptr) return goals;
  for (const scene::XmlElement& step : procedure->children) {
    if (!step.Get("id").empty()) TakeTransitions(scenario, step, &goals[step.Get("id")]);
  }
  return goals;
}

void AddPlannedWays(const scene::Scenario& scenario, const std::vector<StepGoal>& goals, Scene* scene) {
  for (const StepGoal& goal : goals) {
    if (goal.mechanism >= 0) {
      AddWayToSocket(scenario.mechanisms[static_cast<std::size_t>(goal.mechanism)], scene);
      continue;
    }
    const auto at = [&](int object) {
      return glm::vec3(scene->instances[static_cast<std::size_t>(object)].X_WM.translation);
    };
    AddWay({at(goal.palm), at(goal.object)}, scene);
  }
}

}  // namespace view
