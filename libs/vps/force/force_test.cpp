#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "vps/force/force_scale.hpp"
#include "vps/force/reduce_contacts.hpp"

namespace vps {
namespace {

TEST(ForceScale, IsContinuousAndMonotone) {
  constexpr std::size_t kNumPoints = 50000;  // rho N = 500
  double previous = ForceScale(1, kNumPoints);
  double previous_total = previous;
  for (std::size_t n = 2; n < 1000; ++n) {
    const double scale = ForceScale(n, kNumPoints);
    EXPECT_LE(scale, previous * (1 + 1e-12));
    EXPECT_GE(static_cast<double>(n) * scale, previous_total * (1 - 1e-12));
    previous = scale;
    previous_total = static_cast<double>(n) * scale;
  }
  EXPECT_NEAR(500 * ForceScale(500, kNumPoints), 1.0, 1e-12);
  EXPECT_NEAR(499 * ForceScale(499, kNumPoints), 1.0, 2e-3);
  EXPECT_EQ(ForceScale(0, kNumPoints), 0.0);
}

TEST(ForceScale, MatchesHandComputedValues) {
  // N = 1000, rho N = 10, n = 1: (ln(12.718...)/ln(3.718...))^2 / 10.
  const double expected = std::pow(std::log(10 + std::exp(1.0)) / std::log(1 + std::exp(1.0)), 2) / 10;
  EXPECT_NEAR(ForceScale(1, 1000), expected, 1e-15);
  EXPECT_EQ(ForceScale(200, 1000), 1.0 / 200);
}

// A face of 21 x 21 points, 10 mm wide, pressed to `penetration` with a tilt about y.
std::vector<SampledContact> Face(float penetration_m, float tilt_rad) {
  std::vector<SampledContact> contacts;
  for (int i = -10; i <= 10; ++i) {
    for (int j = -10; j <= 10; ++j) {
      const glm::vec3 p(0.0005f * static_cast<float>(i), 0.0005f * static_cast<float>(j), 0.0f);
      contacts.push_back({p, {0, 0, 1}, penetration_m + tilt_rad * p.x});
    }
  }
  return contacts;
}

double Gap(const core::ContactPlane& plane, const core::Pose& X_GS) {
  return glm::dot(glm::dvec3(plane.n_G), X_GS * glm::dvec3(plane.p_S) - glm::dvec3(plane.q_G));
}

TEST(ReduceContacts, KeepsTheGapOfEveryPlane) {
  const core::Pose X_GS{core::QuaternionFromRotationVector({0.1, -0.2, 0.4}), {0.02, 0.01, -0.03}};
  const std::vector<SampledContact> contacts = Face(3e-4f, 0.01f);
  ContactPlanes planes;
  ReduceContacts(contacts, X_GS, 1e4, 1e-3, &planes);
  ASSERT_GE(planes.size(), 4u);
  for (const core::ContactPlane& plane : planes) {
    const double penetration = 3e-4 + 0.01 * static_cast<double>(plane.p_S.x);
    EXPECT_NEAR(Gap(plane, X_GS), -penetration, 1e-8);
  }
}

TEST(ReduceContacts, AFlatFaceIsHeldAtItsCorners) {
  ContactPlanes planes;
  ReduceContacts(Face(3e-4f, 0.0f), {}, 1e4, 1e-3, &planes);
  std::set<std::pair<int, int>> corners;
  double stiffness = 0.0;
  for (const core::ContactPlane& plane : planes) {
    stiffness += static_cast<double>(plane.stiffness_N_per_m);
    if (std::abs(plane.p_S.x) > 0.0049f && std::abs(plane.p_S.y) > 0.0049f) {
      corners.insert({plane.p_S.x > 0 ? 1 : -1, plane.p_S.y > 0 ? 1 : -1});
    }
  }
  EXPECT_EQ(corners.size(), 4u);
  EXPECT_NEAR(stiffness, 1e4, 1.0);
}

TEST(ReduceContacts, KeepsTheDeepestOfEveryDirection) {
  std::vector<SampledContact> contacts;
  for (int i = 0; i < 400; ++i) {  // normals all around, so that every bin is filled and planes run out
    const float a = 0.1f * static_cast<float>(i);
    const float z = -1.0f + 2.0f * static_cast<float>(i) / 399.0f;
    const float r = std::sqrt(1.0f - z * z);
    const glm::vec3 n(r * std::cos(a), r * std::sin(a), z);
    contacts.push_back({-0.01f * n, n, i == 137 ? 5e-4f : 1e-4f});
  }
  ContactPlanes planes;
  ReduceContacts(contacts, {}, 1e4, 1e-5, &planes);
  EXPECT_EQ(planes.size(), core::kMaxContactPlanes);
  EXPECT_NEAR(Gap(planes[0], {}), -5e-4, 1e-8);
  EXPECT_LT(glm::length(planes[0].p_S - contacts[137].p_S), 1e-9f);
}

TEST(ReduceContacts, IdsStayWhileTheContactSlides) {
  ContactPlanes before;
  ContactPlanes after;
  ReduceContacts(Face(3e-4f, 0.01f), {}, 1e4, 1e-3, &before);
  ReduceContacts(Face(2.9e-4f, 0.011f), core::Pose{{1, 0, 0, 0}, {1e-4, 0, 0}}, 1e4, 1e-3, &after);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_EQ(before[i].id, after[i].id);
}

}  // namespace
}  // namespace vps
