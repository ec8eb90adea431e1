// Time per step: free rotation beside Bullet's own world; heavy on light with the direct solver; reduction of contacts.
// Run with --benchmark_enable_random_interleaving=true --benchmark_repetitions=15 and compare medians.
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <benchmark/benchmark.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <vector>

#include "physics/contact_points.hpp"
#include "physics/world.hpp"

namespace {

constexpr double kDt = 1e-3;

physics::MassProperties Triaxial() {
  physics::MassProperties m;
  m.mass_kg = 1.0;
  m.I_Cm_O_kg_m2 = glm::dmat3(1.0);
  m.I_Cm_O_kg_m2[1][1] = 2.0;
  m.I_Cm_O_kg_m2[2][2] = 3.0 - 1e-9;
  return m;
}

// Bodies far apart that tumble about their middle axis.
void OurRotation(benchmark::State& state) {
  physics::World world;
  for (int i = 0; i < state.range(0); ++i) {
    physics::BodyParams params{physics::BodyKind::kDynamic, {}, {{0.01, 2.0, 0.01}, {}}, Triaxial()};
    params.X_WO.translation.x = 100.0 * i;
    if (!world.AddBody(params)) return state.SkipWithError("body refused");
  }
  for (auto _ : state) world.Step(kDt);
}

void BulletRotation(benchmark::State& state) {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity({0, 0, 0});
  btBoxShape shape({0.1, 0.1, 0.1});
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  for (int i = 0; i < state.range(0); ++i) {
    btRigidBody::btRigidBodyConstructionInfo info(1.0, nullptr, &shape, {1, 2, 3});
    info.m_startWorldTransform.setIdentity();
    info.m_startWorldTransform.setOrigin({100.0 * i, 0, 0});
    bodies.push_back(std::make_unique<btRigidBody>(info));
    bodies.back()->setAngularVelocity({0.01, 2.0, 0.01});
    bodies.back()->setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(bodies.back().get());
  }
  for (auto _ : state) world.stepSimulation(kDt, 0);
  for (auto& body : bodies) world.removeRigidBody(body.get());
}

BENCHMARK(OurRotation)->Arg(1)->Arg(20);
BENCHMARK(BulletRotation)->Arg(1)->Arg(20);

// A block of range(0) times the mass on one of 0.2 kg on the ground, hard contact with friction, its weight at 1 g.
void HeavyOnLight(benchmark::State& state) {
  const double light_kg = 0.2;
  const auto ratio = static_cast<double>(state.range(0));
  physics::World world;
  const auto add = [&](double mass, double z) {
    return *world.AddBody(
        {physics::BodyKind::kDynamic, {{1, 0, 0, 0}, {0, 0, z}}, {}, physics::BoxMass(mass, {0.1, 0.1, 0.1})});
  };
  const int light = add(light_kg, 0.05);
  const int heavy = add(ratio * light_kg, 0.15);
  const int lower = *world.AddContactPair(light, world.world_body(), physics::ContactKind::kHard);
  const int upper = *world.AddContactPair(heavy, light, physics::ContactKind::kHard);
  core::ContactSet set;
  set.friction = 0.3f;
  for (int i = 0; i < 4; ++i) {
    core::ContactPlane plane;
    plane.id = static_cast<std::uint32_t>(i);
    plane.p_S = {i % 2 ? 0.05f : -0.05f, i / 2 ? 0.05f : -0.05f, -0.05f};
    plane.n_G = {0, 0, 1};
    plane.stiffness_N_per_m = 1e4f;
    set.planes.push_back(plane);
  }
  world.SetContactPlanes(lower, set);
  for (auto& plane : set.planes) plane.q_G.z = 0.05f;
  world.SetContactPlanes(upper, set);
  world.SetContactWrench(*world.AddContactPair(heavy, world.world_body()), {{0, 0, -9.81 * ratio * light_kg}, {}});
  world.SetContactWrench(*world.AddContactPair(light, world.world_body()), {{0, 0, -9.81 * light_kg}, {}});
  double deepest = 0.0;
  for (auto _ : state) {
    world.Step(kDt);
    deepest = std::max({deepest, -world.SmallestGap_m(lower), -world.SmallestGap_m(upper)});
  }
  state.counters["overlap_um"] = 1e6 * deepest;
  state.counters["fallbacks"] = static_cast<double>(world.num_fallbacks());
}
BENCHMARK(HeavyOnLight)->Arg(1)->Arg(1000)->Arg(5000);

void Reduction(benchmark::State& state) {
  std::vector<physics::ContactPoint> points;
  const int n = static_cast<int>(std::lround(std::sqrt(static_cast<double>(state.range(0)))));
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const glm::dvec3 p_W(0.1 * i / n, 0.1 * j / n, 0.0);
      points.push_back({p_W, {0, 0, 1}, -1e-4 + 1e-3 * p_W.x, 1.0});
    }
  }
  core::FixedVector<core::ContactPlane, core::kMaxContactPlanes> planes;
  for (auto _ : state) {
    physics::ReduceContactPoints(points, {}, {}, &planes);
    benchmark::DoNotOptimize(planes);
  }
}
BENCHMARK(Reduction)->Arg(100)->Arg(10000);

}  // namespace
