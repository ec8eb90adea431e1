#include <cmath>

#include "physics/testing/bodies.hpp"

namespace physics {
namespace {

using test::kDt;

// A box over the floor z = 0 on its four lower corners.
struct HardBox {
  static constexpr double kHalf = 0.05;
  World world;
  int box, pair;

  HardBox(double height, const core::Twist& V, double friction = 0.0, double mass = 0.2) {
    box = test::AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, kHalf + height}}, BoxMass(mass, {0.1, 0.1, 0.1}), V);
    pair = world.AddContactPair(box, world.world_body(), ContactKind::kHard).value();
    core::ContactSet set;
    set.friction = static_cast<float>(friction);
    std::uint32_t id = 0;
    for (const double x : {-kHalf, kHalf}) {
      for (const double y : {-kHalf, kHalf}) test::AddPlane(&set, ++id, {x, y, -kHalf}, {0, 0, 0}, {0, 0, 1}, 1e4);
    }
    world.SetContactPlanes(pair, set);
  }
};

TEST(HardContact, StopsTheBodyAtTheSurfaceWithoutRebound) {
  HardBox scene(0.00123, {{}, {0, 0, -0.7}});  // 0.7 mm a step: it would be 0.17 mm deep after the second
  for (int i = 0; i < 100; ++i) {
    scene.world.Step(kDt);
    EXPECT_GT(scene.world.SmallestGap_m(scene.pair), -1e-7) << i;
  }
  EXPECT_NEAR(scene.world.SmallestGap_m(scene.pair), 0.0, 1e-7);
  EXPECT_NEAR(scene.world.V_WO(scene.box).linear_m_per_s.z, 0.0, 1e-6);
}

TEST(HardContact, CorrectsOverlapNoFasterThanTheGivenSpeed) {
  HardBox scene(-0.003, {});
  for (int i = 0; i < 200; ++i) {
    scene.world.Step(kDt);
    EXPECT_LE(scene.world.V_WO(scene.box).linear_m_per_s.z, 0.02 + 1e-9);
  }
  EXPECT_GT(scene.world.SmallestGap_m(scene.pair), -1e-6);
}

TEST(HardContact, NeverPullsASeparatingBody) {
  HardBox scene(0.0, {{}, {0, 0, 0.1}});
  scene.world.Step(kDt);
  EXPECT_EQ(scene.world.contact(scene.pair).num_pushing, 0);
  EXPECT_DOUBLE_EQ(scene.world.V_WO(scene.box).linear_m_per_s.z, 0.1);
}

TEST(HardContact, SlidingBodyStopsAfterTheCoulombDistance) {
  HardBox scene(0.0, {{}, {0.3, 0.1, 0}}, 0.25);
  const int load = scene.world.AddContactPair(scene.box, scene.world.world_body()).value();
  scene.world.SetContactWrench(load, {{0, 0, -0.2 * 9.81}, {}});
  for (int i = 0; i < 1000; ++i) scene.world.Step(kDt);
  const double v2 = 0.3 * 0.3 + 0.1 * 0.1;
  const glm::dvec3 way = scene.world.X_WO(scene.box).translation - glm::dvec3(0, 0, HardBox::kHalf);
  EXPECT_NEAR(std::hypot(way.x, way.y), v2 / (2 * 0.25 * 9.81), 2e-4);
  EXPECT_LT(glm::length(scene.world.V_WO(scene.box).linear_m_per_s), 1e-9);
}

// Two hands that close on a body leave no solution without overlap: the force must stay bounded and the body in place.
TEST(HardContact, BodySqueezedBetweenTwoHandsStaysBetweenThem) {
  World world;
  const int box = test::AddDynamic(&world, {}, BoxMass(0.2, {0.1, 0.1, 0.1}));
  int hands[2];
  int pairs[2];
  for (const int i : {0, 1}) {
    const double side = i == 0 ? -1.0 : 1.0;
    hands[i] = test::MustAdd(&world, BodyParams{BodyKind::kKinematic, {{1, 0, 0, 0}, {side * 0.0501, 0, 0}}, {}, {}});
    pairs[i] = world.AddContactPair(box, hands[i], ContactKind::kHard).value();
    core::ContactSet set;
    set.friction = 0.5f;
    test::AddPlane(&set, 1, {side * 0.05, 0.01, 0}, {0, 0, 0}, {-side, 0, 0}, 1e4);
    test::AddPlane(&set, 2, {side * 0.05, -0.01, 0}, {0, 0, 0}, {-side, 0, 0}, 1e4);
    world.SetContactPlanes(pairs[i], set);
  }
  double x = 0.0501;
  for (int i = 0; i < 100; ++i) {
    x -= 0.05 * kDt;
    for (const int h : {0, 1}) {
      const double side = h == 0 ? -1.0 : 1.0;
      world.SetKinematic(hands[h], {{1, 0, 0, 0}, {side * x, 0, 0}}, {{}, {-side * 0.05, 0, 0}});
    }
    world.Step(kDt);
    ASSERT_LT(glm::length(world.X_WO(box).translation), 1e-4) << i;
    ASSERT_LT(glm::length(world.V_WO(box).linear_m_per_s), 0.06) << i;
  }
}

}  // namespace
}  // namespace physics
