#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "physics/contact_points.hpp"
#include "physics/test_support.hpp"

namespace physics::test {

// A press of 2 kg with 10,000 points on the table, 60 N off its centre, pulled to and fro below the limit of friction.
// Once settled no corner may move by more than 5 um along the normal.
inline double RockingOfAPress_m(double seconds) {
  World world;
  constexpr double kHalf = 0.05;
  const int press = AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, 0.02}}, BoxMass(2.0, {0.1, 0.1, 0.04}));
  const int pair = world.AddContactPair(press, world.world_body()).value();
  const int load = world.AddContactPair(press, world.world_body()).value();
  std::vector<ContactPoint> points(10000);
  double lowest[4] = {1e9, 1e9, 1e9, 1e9};
  double highest[4] = {-1e9, -1e9, -1e9, -1e9};
  const int steps = static_cast<int>(std::lround(seconds / kDt));
  for (int t = -1000; t < steps; ++t) {
    const core::Pose X_WS = world.X_WO(press);
    for (int i = 0; i < 100; ++i) {
      for (int j = 0; j < 100; ++j) {
        const glm::dvec3 p_W = X_WS * glm::dvec3((i - 49.5) * 1e-3, (j - 49.5) * 1e-3, -0.02);
        points[static_cast<std::size_t>(100 * i + j)] = {p_W, {0, 0, 1}, p_W.z, 20.0};
      }
    }
    core::ContactSet set;
    set.friction = 0.3f;
    set.damping_N_s_per_m = 100.0f;
    ReduceContactPoints(points, X_WS, {}, &set.planes);
    world.SetContactPlanes(pair, set);
    // Off the centre by 15 mm and, at the foot, sideways with a third of what friction can hold.
    const glm::dvec3 force_W(6.0 * std::sin(0.02 * t), 0, -60.0);
    const glm::dvec3 at(0.01, 0.012, -0.02);
    world.SetContactWrench(load, {force_W, glm::cross(at, force_W)});
    world.Step(kDt);
    if (t < 0) continue;
    for (int c = 0; c < 4; ++c) {
      const double z = (world.X_WO(press) * glm::dvec3(c % 2 ? kHalf : -kHalf, c / 2 ? kHalf : -kHalf, -0.02)).z;
      lowest[c] = std::min(lowest[c], z);
      highest[c] = std::max(highest[c], z);
    }
  }
  double most = 0.0;
  for (int c = 0; c < 4; ++c) most = std::max(most, highest[c] - lowest[c]);
  ::testing::Test::RecordProperty("rocking_nm", std::to_string(most * 1e9));
  return most;
}

}  // namespace physics::test
