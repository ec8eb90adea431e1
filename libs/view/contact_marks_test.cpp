#include "view/contact_marks.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace view {
namespace {

constexpr double kPi = 3.14159265358979323846;

// One plane of G = W with normal z through the origin; a point of S at `p_S`.
core::ContactSet SetWithPoint(const glm::vec3& p_S) {
  core::ContactSet set;
  set.is_in_contact = true;
  core::ContactPlane plane;
  plane.p_S = p_S;
  plane.n_G = {0.0f, 0.0f, 1.0f};
  plane.stiffness_N_per_m = 1000.0f;
  set.planes.push_back(plane);
  return set;
}

TEST(ContactMarks, AnArrowHasTheForcesDirectionAndTheLengthOfTheTable) {
  const glm::dvec3 force_N = 5.0 * glm::normalize(glm::dvec3(1.0, 2.0, -2.0));
  const Arrow arrow = ForceArrow({1, 2, 3}, force_N, kContactColor);
  EXPECT_EQ(arrow.p_WTail, glm::dvec3(1, 2, 3));
  EXPECT_NEAR(glm::length(arrow.vector_W), kArrowBase_m + 5.0 * kArrowPerNewton_m, 1e-15);
  EXPECT_NEAR(glm::dot(glm::normalize(arrow.vector_W), force_N), 5.0, 1e-14);
  EXPECT_NEAR(glm::length(ForceArrow({}, {0, 0, 1000.0}, kContactColor).vector_W), kArrowMax_m, 1e-15);
}

TEST(ContactMarks, ARingTurnsAboutTheTorqueByTheSweepOfTheTable) {
  const RingArrow ring = TorqueRing({1, 2, 3}, {0.0, -0.8, 0.6}, kContactColor);
  EXPECT_LT(glm::distance(ring.axis_W, glm::dvec3(0.0, -0.8, 0.6)), 1e-15);
  EXPECT_NEAR(ring.sweep_rad, kRingBase_rad + kRingPerNm_rad, 1e-15);
  EXPECT_EQ(TorqueRing({}, {9.0, 0.0, 0.0}, kContactColor).sweep_rad, kRingMax_rad);
}

TEST(ContactMarks, AContactBesideTheOriginTurnsThePart) {
  // 3 mm deep: 3 N along z, 0.1 m beside So along x. The torque is (0.1, 0, ...) x (0, 0, 3) = -0.3 y. S is turned by a
  // right angle about z, so its own x is W's y: then the torque is 0.3 x.
  core::Pose X_WS;
  X_WS.rotation = glm::angleAxis(kPi / 2.0, glm::dvec3(0, 0, 1));
  const core::ContactSet set = SetWithPoint({0.1f, 0.0f, -0.003f});
  Scene scene;
  AddTorqueRing({set, X_WS, {}, X_WS}, &scene);
  ASSERT_EQ(scene.rings.size(), 1u);
  EXPECT_LT(glm::distance(scene.rings[0].axis_W, glm::dvec3(1.0, 0.0, 0.0)), 1e-7);
  EXPECT_NEAR(scene.rings[0].sweep_rad, kRingBase_rad + kRingPerNm_rad * 0.3, 1e-7);
}

TEST(ContactMarks, DepthsAreColouredFromBlueToRed) {
  std::vector<glm::vec3> p_W, colors;
  const core::ContactSet set = SetWithPoint({0.0f, 0.0f, static_cast<float>(-kFullDepth_m)});
  AddDepthPoints({set, {}, {}, {}}, &p_W, &colors);
  ASSERT_EQ(p_W.size(), 1u);
  EXPECT_EQ(colors[0], HeatColor(1.0));
  EXPECT_GT(HeatColor(1.0).r, 0.9f);
  EXPECT_GT(HeatColor(0.0).b, 0.9f);
  EXPECT_GT(HeatColor(0.5).g, 0.9f);
  EXPECT_EQ(HeatColor(7.0), HeatColor(1.0));
}

TEST(ContactMarks, ADistanceLineEndsOnThePlaneAndSaysItsLength) {
  const core::ContactSet set = SetWithPoint({0.02f, 0.0f, 0.0f});
  core::Pose X_WS;
  X_WS.translation = {0.0, 0.0, 0.0015};
  Scene scene;
  AddDistance({set, X_WS, {}, X_WS}, &scene);
  ASSERT_EQ(scene.lines.size(), 1u);
  EXPECT_LT(glm::distance(scene.lines[0].p_W->back(), glm::vec3(0.02f, 0.0f, 0.0f)), 1e-7f);
  ASSERT_EQ(scene.labels.size(), 1u);
  EXPECT_EQ(scene.labels[0].text, "1.50 mm");
  X_WS.translation.z = -0.001;
  AddDistance({set, X_WS, {}, X_WS}, &scene);
  EXPECT_EQ(scene.lines.size(), 1u) << "penetrates";
}

}  // namespace
}  // namespace view
