#include "vps/coupling/nearest_point.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "vps/testing/case_random.hpp"

namespace vps {
namespace {

Vector6 RandomVector(CaseRandom& random, double scale) {
  Vector6 v;
  for (double& x : v) x = random.Uniform(-scale, scale);
  return v;
}

// Solves G u = c by elimination with pivots; false when G is singular.
bool Solve(std::vector<std::vector<double>> G, std::vector<double> c, std::vector<double>* u) {
  const std::size_t n = c.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k; i < n; ++i) pivot = std::abs(G[i][k]) > std::abs(G[pivot][k]) ? i : pivot;
    if (std::abs(G[pivot][k]) < 1e-9) return false;
    std::swap(G[k], G[pivot]);
    std::swap(c[k], c[pivot]);
    for (std::size_t i = k + 1; i < n; ++i) {
      const double f = G[i][k] / G[k][k];
      for (std::size_t j = k; j < n; ++j) G[i][j] -= f * G[k][j];
      c[i] -= f * c[k];
    }
  }
  u->assign(n, 0.0);
  for (std::size_t k = n; k-- > 0;) {
    double sum = c[k];
    for (std::size_t j = k + 1; j < n; ++j) sum -= G[k][j] * (*u)[j];
    (*u)[k] = sum / G[k][k];
  }
  return true;
}

// Every set of half-spaces taken as equations; of the points that are allowed the one next to the target.
bool NearestByEnumeration(const Vector6& target, const HalfSpaces& h, Vector6* nearest) {
  double least = 1e300;
  for (std::uint32_t set = 0; set < (1U << h.count); ++set) {
    std::vector<std::size_t> members;
    for (std::size_t i = 0; i < h.count; ++i) {
      if ((set >> i & 1U) != 0) members.push_back(i);
    }
    if (members.size() > 6) continue;
    std::vector<std::vector<double>> G(members.size(), std::vector<double>(members.size()));
    std::vector<double> c;
    for (std::size_t i = 0; i < members.size(); ++i) {
      for (std::size_t j = 0; j < members.size(); ++j) G[i][j] = Dot(h.of[members[i]].a, h.of[members[j]].a);
      c.push_back(h.of[members[i]].b - Dot(h.of[members[i]].a, target));
    }
    std::vector<double> u;
    if (!Solve(G, c, &u)) continue;
    Vector6 y = target;
    for (std::size_t i = 0; i < members.size(); ++i) AddScaled(u[i], h.of[members[i]].a, &y);
    bool is_allowed = true;
    for (std::size_t i = 0; i < h.count; ++i) is_allowed = is_allowed && Dot(h.of[i].a, y) >= h.of[i].b - 1e-9;
    double distance = 0.0;
    for (std::size_t k = 0; k < 6; ++k) distance += (y[k] - target[k]) * (y[k] - target[k]);
    if (!is_allowed || distance >= least) continue;
    least = distance;
    *nearest = y;
  }
  return least < 1e300;
}

TEST(NearestPoint, IsTheOneThatAllActiveSetsGive) {
  CaseRandom random(1);
  for (int round = 0; round < 400; ++round) {
    HalfSpaces h;
    h.count = 1 + random.Below(9);
    const Vector6 inside = RandomVector(random, 0.5);  // so there is a solution
    for (std::size_t i = 0; i < h.count; ++i) {
      h.of[i].a = RandomVector(random, 1.0);
      h.of[i].b = Dot(h.of[i].a, inside) - (random.Below(3) == 0 ? 0.0 : random.Uniform(0.0, 0.5));
      if (i > 0 && random.Below(5) == 0) h.of[i] = h.of[i - 1];  // redundant
      h.of[i].was_active = random.Below(2) == 0;
    }
    const Vector6 target = RandomVector(random, 3.0);
    Vector6 expected{};
    ASSERT_TRUE(NearestByEnumeration(target, h, &expected));
    NearestPoint result;
    ProjectOntoHalfSpaces(target, h, &result);
    EXPECT_EQ(result.worst_violation, 0.0);
    Vector6 sum = target;
    for (std::size_t i = 0; i < h.count; ++i) {
      EXPECT_GE(result.multipliers[i], 0.0);
      EXPECT_GE(Dot(h.of[i].a, result.y), h.of[i].b - 1e-9);
      EXPECT_LT(std::abs(result.multipliers[i] * (Dot(h.of[i].a, result.y) - h.of[i].b)), 1e-8);
      AddScaled(result.multipliers[i], h.of[i].a, &sum);
    }
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_NEAR(result.y[k], expected[k], 1e-8) << round;
      EXPECT_NEAR(result.y[k], sum[k], 1e-9) << round;
    }
  }
}

// A face has many planes that say the same, and a ring hundreds of directions: 96 half-spaces about a ball.
TEST(NearestPoint, MeetsEveryOptimalityConditionOfManyHalfSpaces) {
  CaseRandom random(2);
  for (int round = 0; round < 300; ++round) {
    HalfSpaces h;
    h.count = 96;
    for (std::size_t i = 0; i < h.count; ++i) {
      h.of[i].a = RandomVector(random, 1.0);
      if (i > 48) h.of[i].a = h.of[i - 48].a;
      const double norm = std::sqrt(Dot(h.of[i].a, h.of[i].a));
      h.of[i].b = -1e-3 * norm * (1.0 + (i > 48 ? 1e-9 : 0.0));
    }
    NearestPoint result;
    const Vector6 target = RandomVector(random, 0.1);
    ProjectOntoHalfSpaces(target, h, &result);
    EXPECT_EQ(result.worst_violation, 0.0);
    Vector6 sum = target;
    for (std::size_t i = 0; i < h.count; ++i) {
      EXPECT_GE(Dot(h.of[i].a, result.y), h.of[i].b - 1e-10);
      EXPECT_LT(result.multipliers[i] * (Dot(h.of[i].a, result.y) - h.of[i].b), 1e-9);
      AddScaled(result.multipliers[i], h.of[i].a, &sum);
    }
    for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(result.y[k], sum[k], 1e-10);
  }
}

// As two jaws whose gap is a part's width to a nanometre, and whose pads are not quite parallel. To meet the nanometre
// they would have to press against each other a thousand times as hard as they are pushed.
TEST(NearestPoint, NearlyOppositeHalfSpacesDoNotPressAgainstEachOther) {
  HalfSpaces h;
  h.count = 2;
  h.of[0] = {{1, 0, 0, 0, 0, 0}, 0.0};
  h.of[1] = {{-1, 1e-4, 0, 0, 0, 0}, 1e-9};
  NearestPoint result;
  ProjectOntoHalfSpaces({-1e-4, 0, 0, 0, 0, 0}, h, &result);
  EXPECT_LT(result.multipliers[0], 1.1e-4);
  EXPECT_LT(result.multipliers[1], 1e-5);
  EXPECT_LT(result.worst_violation, 1e-6);
}

TEST(NearestPoint, SaysByHowMuchHalfSpacesContradictEachOther) {
  HalfSpaces h;
  h.count = 2;
  h.of[0] = {{1, 0, 0, 0, 0, 0}, 0.5};
  h.of[1] = {{-1, 0, 0, 0, 0, 0}, -0.3};
  NearestPoint result;
  ProjectOntoHalfSpaces({}, h, &result);
  EXPECT_NEAR(result.worst_violation, 0.2, 1e-12);
}

}  // namespace
}  // namespace vps
