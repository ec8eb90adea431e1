#include "view/robot_marks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/gtc/constants.hpp>
#include <utility>

namespace view {
namespace {

constexpr glm::vec3 kArcColor{0.85f, 0.08f, 0.06f};
constexpr glm::vec3 kTargetColor{0.1f, 0.75f, 0.25f};
constexpr glm::vec3 kBeadColor{0.55f, 0.58f, 0.62f};
constexpr glm::vec3 kLabelColor{0.9f, 0.92f, 0.95f};

// Spheres from link to link and to the hand, a radius apart.
Spheres Beads(const core::DeviceJoints& robot, bool is_target) {
  auto beads = std::make_shared<std::vector<glm::vec4>>();
  const std::size_t size = robot.joints.size();
  for (std::size_t i = 0; i < size; ++i) {
    const core::DeviceJoint& joint = robot.joints[i];
    const auto origin = [&](std::size_t k) {
      if (k == size) return is_target ? robot.X_WD_target.translation : robot.X_WD.translation;
      return is_target ? robot.joints[k].X_WL_target.translation : robot.joints[k].X_WL.translation;
    };
    const glm::dvec3 from = origin(i), to = origin(i + 1);
    const double radius_m = std::max(0.005, static_cast<double>(joint.radius_m));
    const int num = std::max(1, static_cast<int>(std::ceil(glm::distance(from, to) / radius_m)));
    for (int k = 0; k < num; ++k) {
      beads->emplace_back(glm::vec3(glm::mix(from, to, static_cast<double>(k) / num)), static_cast<float>(radius_m));
    }
  }
  Spheres spheres;
  spheres.p_P_radius_m = std::move(beads);
  spheres.color = is_target ? kTargetColor : kBeadColor;
  spheres.opacity = is_target ? 0.35f : 0.6f;
  return spheres;
}

// Turned by the torque that the joint feels beyond its command: half a turn at kHalfTurn_Nm, a whole one at most.
void AddArc(const core::DeviceJoint& joint, Scene* scene) {
  const double off_Nm = static_cast<double>(joint.measured_Nm) - static_cast<double>(joint.commanded_Nm);
  if (!(std::abs(off_Nm) >= kLeastArc_Nm)) return;
  RingArrow arc;
  arc.p_WCentre = joint.X_WL.translation;
  arc.axis_W = joint.X_WL.rotate({0.0, 0.0, off_Nm < 0.0 ? -1.0 : 1.0});
  arc.radius_m = 1.6 * static_cast<double>(joint.radius_m);
  arc.sweep_rad = std::min(std::abs(off_Nm) / kHalfTurn_Nm * glm::pi<double>(), 1.9 * glm::pi<double>());
  arc.color = kArcColor;
  scene->rings.push_back(arc);
}

void AddBillboard(const core::DeviceJoint& joint, std::size_t number, Scene* scene) {
  char text[96];
  std::snprintf(text, sizeof text, "%zu: %.1f deg  %.1f Nm  %.0f degC", number,
                static_cast<double>(joint.position_rad) * 180.0 / glm::pi<double>(),
                static_cast<double>(joint.measured_Nm), static_cast<double>(joint.temperature_degC));
  scene->labels.push_back({joint.X_WL.translation, text, kLabelColor, static_cast<double>(joint.radius_m)});
}

}  // namespace

const char* RobotStateName(std::uint8_t state) {
  constexpr const char* kNames[] = {"OFF", "IDLE", "READY", "ENGAGING", "FORCE", "DEGRADED", "BRAKE", "FAULT"};
  return state < std::size(kNames) ? kNames[state] : "?";
}

const char* RobotCauseName(std::uint8_t cause) {
  constexpr const char* kNames[] = {
      "", "not finite", "position sensors", "torque sensors", "force sensor", "clutch", "heat", "speed"};
  return cause < std::size(kNames) ? kNames[cause] : "?";
}

void AddRobot(const core::DeviceJoints& robot, Scene* scene) {
  if (robot.joints.empty()) return;
  scene->spheres.push_back(Beads(robot, false));
  if (robot.has_target) scene->spheres.push_back(Beads(robot, true));
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    AddArc(robot.joints[i], scene);
    AddBillboard(robot.joints[i], i + 1, scene);
  }
  std::string state = std::string(robot.is_simulated ? "SIMULATED  " : "") + RobotStateName(robot.state);
  if (robot.first_cause != 0) state += std::string(": ") + RobotCauseName(robot.first_cause);
  scene->labels.push_back({robot.X_WD.translation, state, kLabelColor, 0.05});
}

}  // namespace view
