#include "physics/testing/trials/reference.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "physics/spring_coupling.hpp"
#include "physics/testing/closed_form/free_rotation.hpp"
#include "physics/testing/contact_points.hpp"
#include "physics/testing/trials/build.hpp"

namespace physics::trials {
namespace {

glm::dvec3 TotalMomentum(const World& world, const std::vector<int>& bodies) {
  glm::dvec3 p(0.0);
  for (const int body : bodies) p += world.momentum_Ns(body);
  return p;
}
glm::dvec3 TotalAngularMomentum(const World& world, const std::vector<int>& bodies) {
  glm::dvec3 L(0.0);
  for (const int body : bodies) {
    L += world.spin_Nms(body) + glm::cross(world.center_of_mass_W(body), world.momentum_Ns(body));
  }
  return L;
}

}  // namespace

double DriftError() {
  World world;
  const glm::dvec3 start(0.1, -0.7, 3.0);
  const glm::dvec3 v(0.1, -0.0317, 0.77777);
  const int body = AddDynamic(&world, {{1, 0, 0, 0}, start}, BoxMass(2.0, {0.1, 0.2, 0.3}), {{}, v});
  double worst = 0.0;
  for (int i = 1; i <= 600000; ++i) {
    world.Step(kDt);
    if (i % 1000 != 0) continue;
    const double t = i * kDt;
    const glm::dvec3 exact = closed_form::DriftPosition(start, v, t);
    worst = std::max(worst, glm::length(world.center_of_mass_W(body) - exact) / glm::length(v * t));
  }
  return worst;
}

MomentumResidual MixedContacts(double seconds) {
  World world;
  std::vector<int> bodies;
  std::vector<int> pairs;
  for (int i = 0; i < 4; ++i) {
    bodies.push_back(AddDynamic(&world, {{1, 0, 0, 0}, {0.11 * i, 0.003 * i, 0}},
                                BoxMass(0.3 + 0.8 * i, {0.1, 0.08, 0.12}),
                                {{0.02 * i, -0.03, 0.01}, {0.2 - 0.15 * i, 0.01 * i, -0.01}}));
  }
  for (std::size_t i = 0; i + 1 < bodies.size(); ++i) {
    auto* spring = AddMechanism<SpringCoupling>(&world, bodies[i], bodies[i + 1], SpringCouplingParams{40, 0, 0.5, 0});
    const core::Pose X_P = world.X_WO(bodies[i]);
    const core::Pose X_C = world.X_WO(bodies[i + 1]);
    spring->Attach(X_P, X_C, 0.5 * (X_P.translation + X_C.translation));
    pairs.push_back(world.AddContactPair(bodies[i], bodies[i + 1]).value());
    core::ContactSet set;
    set.friction = 0.3f;
    std::uint32_t id = 0;
    for (const double y : {-0.03, 0.03}) {
      for (const double z : {-0.05, 0.05}) AddPlane(&set, ++id, {0.05, y, z}, {-0.05, 0, 0}, {-1, 0, 0}, 2e4);
    }
    world.SetContactPlanes(pairs.back(), set);
  }
  const glm::dvec3 p = TotalMomentum(world, bodies);
  const glm::dvec3 L = TotalAngularMomentum(world, bodies);
  MomentumResidual residual;
  const int steps = static_cast<int>(std::lround(seconds / kDt));
  for (int i = 0; i < steps; ++i) {
    world.Step(kDt);
    for (const int pair : pairs) residual.num_pushes += world.contact(pair).num_pushing > 0 ? 1 : 0;
  }
  const ImpulseBalance balance = world.impulse_balance();
  residual.linear = glm::length(TotalMomentum(world, bodies) - p) / balance.linear_magnitude_Ns;
  residual.angular = glm::length(TotalAngularMomentum(world, bodies) - L) / balance.angular_magnitude_Nms;
  residual.joints = world.joint_balance();
  residual.contacts = world.contact_balance();
  return residual;
}

SlopeFigures BlockOnSlope(double tangent, double friction, ContactKind kind) {
  constexpr double kMass = 1.0;
  World world;
  const int block = AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, 0.02}}, BoxMass(kMass, {0.1, 0.1, 0.04}));
  const int pair = world.AddContactPair(block, world.world_body(), kind).value();
  core::ContactSet set;
  set.friction = static_cast<float>(friction);
  set.damping_N_s_per_m = 50.0f;
  std::uint32_t id = 0;
  for (const double x : {-0.05, 0.05}) {
    for (const double y : {-0.05, 0.05}) AddPlane(&set, ++id, {x, y, -0.02}, {0, 0, 0}, {0, 0, 1}, 2.5e4);
  }
  world.SetContactPlanes(pair, set);
  // The slope is the plane z = 0 with +x downhill; the weight is turned instead.
  const double angle = std::atan(tangent);
  world.SetLoad(block, {kMass * kGravity * glm::dvec3(std::sin(angle), 0, -std::cos(angle)), {}});
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) world.Step(kDt);
  };
  SlopeFigures figures;
  run(1000);
  const double v0 = world.momentum_Ns(block).x / kMass;
  run(1000);
  figures.acceleration_m_per_s2 = world.momentum_Ns(block).x / kMass - v0;
  const double x0 = world.center_of_mass_W(block).x;
  run(10000);
  figures.creep_m_per_s = std::abs(world.center_of_mass_W(block).x - x0) / 10.0;
  return figures;
}

SolverWork WorkOfAMover(int num_far) {
  World world;
  const int mover =
      AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, 0.06}}, BoxMass(0.5, {0.1, 0.1, 0.1}), {{0.1, 0, 0}, {0, 0, -0.2}});
  const int pair = world.AddContactPair(mover, world.world_body()).value();
  core::ContactSet set;
  set.friction = 0.3f;
  std::uint32_t id = 0;
  for (const double x : {-0.05, 0.05}) {
    for (const double y : {-0.05, 0.05}) AddPlane(&set, ++id, {x, y, -0.05}, {0, 0, 0}, {0, 0, 1}, 5e3);
  }
  for (int i = 0; i < num_far; ++i) {
    const int far = AddDynamic(&world, {{1, 0, 0, 0}, {10.0 + i, 0, 0}}, BoxMass(1.0, {0.1, 0.1, 0.1}),
                               {{0.1, 0.2, 0.3}, {0.01, 0, 0}});
    world.AddContactPair(far, mover).value();
  }
  for (int i = 0; i < 500; ++i) {
    world.SetContactPlanes(pair, set);
    world.Step(kDt);
  }
  return world.solver_work();
}

double RockingOfAPress_m(double seconds) {
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
    // 15 mm off the centre; at the foot a sideways force of a third of the friction limit (0.3 x 60 N).
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
  return most;
}

}  // namespace physics::trials
