#include "vps/coupling/stick_slip.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace vps {
namespace {

Contact OnPlaneZ(double friction) {
  Contact c;
  c.normal = {0, 0, 1, 0, 0, 0};
  c.tangents = {Vector6{1, 0, 0, 0, 0, 0}, Vector6{0, 1, 0, 0, 0, 0}};
  c.friction = friction;
  return c;
}

// Each from the normal forces of the cycle before.
Vector6 Solve(const Vector6& target, std::vector<Contact>* contacts, int cycles) {
  Vector6 y{};
  for (int cycle = 0; cycle < cycles; ++cycle) {
    for (Contact& c : *contacts) c.limit_N = c.friction * c.normal_N;
    y = SolveStickSlip(target, {}, *contacts);
  }
  return y;
}

TEST(StickSlip, SticksInsideTheConeAndSlipsOnItsRim) {
  for (const double friction : {0.1, 0.3, 0.5}) {
    std::vector<Contact> sticks{OnPlaneZ(friction)};
    Vector6 y = Solve({0.6 * friction, 0.7 * friction, -1, 0, 0, 0}, &sticks, 1);
    EXPECT_NEAR(std::hypot(y[0], y[1], y[2]), 0.0, 1e-7);
    EXPECT_NEAR(sticks[0].tangent_N[0], -0.6 * friction, 1e-7);

    std::vector<Contact> slips{OnPlaneZ(friction)};
    y = Solve({0.8, 0.6, -1, 0, 0, 0}, &slips, 20);
    EXPECT_NEAR(slips[0].tangent_N[0], -0.8 * friction, 1e-7);
    EXPECT_NEAR(slips[0].tangent_N[1], -0.6 * friction, 1e-7);
    EXPECT_NEAR(y[0], 0.8 * (1 - friction), 1e-7);
  }
}

TEST(StickSlip, GivesUpNoMoreThanTheLimitOfAFadingContact) {
  std::vector<Contact> contacts{OnPlaneZ(0.0)};
  contacts[0].most_N = 0.25;
  const Vector6 y = Solve({0, 0, -1, 0, 0, 0}, &contacts, 1);
  EXPECT_NEAR(contacts[0].normal_N, 0.25, 1e-7);
  EXPECT_NEAR(y[2], -0.75, 1e-7);
}

// Of a spring of 2.5 kN/m: a force of 1 N moves by kRow in the unit of y, and by kRow^2 = 0.4 mm.
constexpr double kRow = 0.02;

// From nothing, within five cycles; of fewer than 1 in 50 contacts the limit is off by more than 1 %.
TEST(StickSlip, HoldsCoulombsLawAtTheContactsOfRandomTools) {
  std::mt19937_64 rng(3);
  std::normal_distribution<double> normal;
  int num_sticking = 0;
  int num_slipping = 0;
  int num_off = 0;
  for (int round = 0; round < 500; ++round) {
    std::vector<Contact> contacts(1 + rng() % 4);
    for (Contact& c : contacts) {
      // Places at about one radius from the centre, so that turning and shifting weigh alike.
      const std::array<double, 3> r{normal(rng), normal(rng), normal(rng)};
      std::array<std::array<double, 3>, 3> axes{};
      axes[0] = {0.3 * normal(rng), 0.3 * normal(rng), 1.0};
      axes[1] = {1.0, 0.0, -axes[0][0]};
      for (std::size_t k = 0; k < 2; ++k) {
        const double norm = std::hypot(axes[k][0], axes[k][1], axes[k][2]);
        for (double& x : axes[k]) x /= norm;
      }
      axes[2] = {axes[0][1] * axes[1][2] - axes[0][2] * axes[1][1], axes[0][2] * axes[1][0] - axes[0][0] * axes[1][2],
                 axes[0][0] * axes[1][1] - axes[0][1] * axes[1][0]};
      std::array<Vector6, 3> rows;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& d = axes[k];
        rows[k] = {d[0], d[1], d[2], r[1] * d[2] - r[2] * d[1], r[2] * d[0] - r[0] * d[2], r[0] * d[1] - r[1] * d[0]};
        for (double& x : rows[k]) x *= kRow;
      }
      c.normal = rows[0];
      c.tangents = {rows[1], rows[2]};
      c.friction = 0.3;
      c.bound = -0.1 * kRow * kRow;
      c.slip_m = {0.01 * kRow * kRow * normal(rng), 0.01 * kRow * kRow * normal(rng)};
    }
    Vector6 target;
    for (double& x : target) x = 0.3 * kRow * normal(rng);
    target[2] -= kRow;  // 1 N
    const Vector6 y = Solve(target, &contacts, 5);
    // Contacts give no more energy than the slips before have put in.
    double put_in_J = 0.0, spring_J = 0.0;
    for (const Contact& c : contacts) put_in_J += c.limit_N * std::hypot(c.slip_m[0], c.slip_m[1]);
    for (std::size_t i = 0; i < 6; ++i) spring_J += 0.5 * (y[i] - target[i]) * (y[i] - target[i]);
    EXPECT_LE(spring_J, 0.5 * Dot(target, target) + put_in_J + 1e-12);
    for (const Contact& c : contacts) {
      const double gap = Dot(c.normal, y) - c.bound;
      EXPECT_GT(gap, -1e-4 * kRow * kRow);
      EXPECT_GE(c.normal_N, 0.0);
      EXPECT_LT(c.normal_N * gap, 1e-4 * kRow * kRow);
      const double force = std::hypot(c.tangent_N[0], c.tangent_N[1]);
      EXPECT_LE(force, c.limit_N + 1e-9);
      const double limit = c.friction * c.normal_N;
      num_off += std::abs(c.limit_N - limit) > 0.01 * limit + 1e-3 ? 1 : 0;
      const std::array<double, 2> slip{c.slip_m[0] + Dot(c.tangents[0], y), c.slip_m[1] + Dot(c.tangents[1], y)};
      const double slipped = std::hypot(slip[0], slip[1]);
      if (force < c.limit_N - 1e-3) {
        EXPECT_LT(slipped, 1e-3 * kRow * kRow);
        ++num_sticking;
      } else if (slipped > 0.01 * kRow * kRow && force > 0.01) {
        const double along = (slip[0] * c.tangent_N[0] + slip[1] * c.tangent_N[1]) / (slipped * force);
        EXPECT_LT(along, -0.999);
        ++num_slipping;
      }
    }
  }
  EXPECT_GT(num_sticking, 50);
  EXPECT_GT(num_slipping, 50);
  EXPECT_LT(num_off, (num_sticking + num_slipping) / 50);
}

}  // namespace
}  // namespace vps
