#include "view/arm_posture.hpp"

#include <algorithm>
#include <cmath>

namespace view {
namespace {

constexpr double kAcross = 0.5 * 3.14159265358979323846;

core::Pose TurnedAboutZ(double angle) {
  return {glm::angleAxis(angle, glm::dvec3(0.0, 0.0, 1.0)), glm::dvec3(0.0)};
}

// R = Rz(a) Ry(b) Rz(c) with b in [0, pi]; at b = 0 and pi, where only a + c or a - c counts, a is 0.
glm::dvec3 EulerZyz(const glm::dmat3& R) {  // [column][row]
  const double sine = std::hypot(R[2][0], R[2][1]);
  const double b = std::atan2(sine, R[2][2]);
  if (sine < 1e-12) return {0.0, b, std::atan2(R[0][1], R[1][1])};
  return {std::atan2(R[2][1], R[2][0]), b, std::atan2(R[1][2], -R[0][2])};
}

// v without its part along the unit vector n, as a unit vector; any one across n when nothing is left.
glm::dvec3 Across(const glm::dvec3& v, const glm::dvec3& n) {
  const glm::dvec3 rest = v - glm::dot(v, n) * n;
  if (glm::length(rest) > 1e-9) return glm::normalize(rest);
  return Across(std::abs(n.x) < 0.8 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0), n);
}

}  // namespace

ArmPosture::ArmPosture(const scene::ShownArm& arm) : arm_(arm) {
  const auto along = [&](std::size_t link) { return glm::length(arm.links[link].X_PJ.translation); };
  p_BShoulder_ = {0.0, 0.0, along(0) + along(1)};
  upper_m_ = along(2) + along(3);
  fore_m_ = along(4) + along(5);
  wrist_m_ = along(6);
}

// With v from the shoulder to the wrist, the elbow lies on a circle around v; there it is nearest to the direction that
// the scenario gives. Joints 1 to 3 turn z of link 3 to the elbow and its x into the plane of the arm, joint 4 bends
// it, joints 5 to 7 turn the rest. Each odd joint turns about z, each even one about -y of the link before:
//   R_B3 = Rz(q1) Ry(-q2) Rz(q3),  R_37 = Ry(-q4) Rz(q5) Ry(-q6) Rz(q7).
ArmPosture::Links ArmPosture::At(const core::Pose& X_WF) const {
  const core::Pose X_B7 = arm_.X_WB.inverse() * X_WF * arm_.X_7F.inverse();
  const glm::dmat3 R_B7 = glm::mat3_cast(X_B7.rotation);
  const glm::dvec3 v = X_B7.translation - wrist_m_ * R_B7[2] - p_BShoulder_;
  const double wanted_m = glm::length(v);
  const double far_m = upper_m_ + fore_m_, near_m = std::abs(upper_m_ - fore_m_);
  const double distance_m = std::clamp(wanted_m, std::max(near_m, 1e-6 * far_m), far_m);
  const glm::dvec3 ahead = wanted_m > 1e-9 ? v / wanted_m : glm::dvec3(0, 0, 1);

  const auto angle = [](double cosine) { return std::acos(std::clamp(cosine, -1.0, 1.0)); };
  const double lift =
      angle((upper_m_ * upper_m_ + distance_m * distance_m - fore_m_ * fore_m_) / (2.0 * upper_m_ * distance_m));
  const double bend = 2.0 * kAcross - angle((upper_m_ * upper_m_ + fore_m_ * fore_m_ - distance_m * distance_m) /
                                            (2.0 * upper_m_ * fore_m_));
  const glm::dvec3 elbow = Across(glm::conjugate(arm_.X_WB.rotation) * arm_.elbow_W, ahead);
  const glm::dvec3 z = std::cos(lift) * ahead + std::sin(lift) * elbow;
  const glm::dvec3 x = std::sin(lift) * ahead - std::cos(lift) * elbow;
  const glm::dmat3 R_B3(x, glm::cross(z, x), z);
  const glm::dmat3 R_34 = glm::mat3_cast(glm::angleAxis(bend, glm::dvec3(0, 1, 0)));
  const glm::dvec3 shoulder = EulerZyz(R_B3);
  const glm::dvec3 wrist = EulerZyz(glm::transpose(R_B3 * R_34) * R_B7);

  Links links;
  const std::array<double, kNumJoints> q = {shoulder.x, -shoulder.y, shoulder.z, -bend, wrist.x, -wrist.y, wrist.z};
  core::Pose X_WL = arm_.X_WB;
  for (std::size_t i = 0; i < kNumJoints; ++i) {
    X_WL = X_WL * arm_.links[i].X_PJ * TurnedAboutZ(q[i]);
    links.X_WL[i] = X_WL;
  }
  links.X_WF = X_WL * arm_.X_7F;
  links.is_reached = std::abs(distance_m - wanted_m) < 1e-9;
  return links;
}

}  // namespace view
