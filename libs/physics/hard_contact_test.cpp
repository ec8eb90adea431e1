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

// A box between two hands that move along x at `speed`, each in contact at `num` points across its face.
struct HeldBox {
  static constexpr double kHalf = 0.05;
  World world;
  int box;
  int hands[2];
  int pairs[2];
  double x = 0.0501;  // of the hands' faces

  explicit HeldBox(int num) : box(test::AddDynamic(&world, {}, BoxMass(0.2, {0.1, 0.1, 0.1}))) {
    for (const int i : {0, 1}) {
      hands[i] = test::MustAdd(&world, BodyParams{BodyKind::kKinematic, {{1, 0, 0, 0}, {Side(i) * x, 0, 0}}, {}, {}});
      pairs[i] = world.AddContactPair(box, hands[i], ContactKind::kHard).value();
      world.SetContactPlanes(pairs[i], Planes({Side(i) * kHalf, 0, 0}, {-Side(i), 0, 0}, {0, 0.01, 0}, num));
    }
  }
  static double Side(int i) { return i == 0 ? -1.0 : 1.0; }
  // On a line through p_S, `num` points apart by twice `step`.
  static core::ContactSet Planes(const glm::dvec3& p_S, const glm::dvec3& n_G, const glm::dvec3& step, int num) {
    core::ContactSet set;
    set.friction = 0.5f;
    for (int j = 0; j < num; ++j) {
      test::AddPlane(&set, static_cast<std::uint32_t>(j + 1), p_S + (num - 1.0 - 2.0 * j) * step, {0, 0, 0}, n_G, 1e4);
    }
    return set;
  }
  void Step(double speed) {
    x += speed * kDt;
    for (const int i : {0, 1}) {
      world.SetKinematic(hands[i], {{1, 0, 0, 0}, {Side(i) * x, 0, 0}}, {{}, {Side(i) * speed, 0, 0}});
    }
    world.Step(kDt);
  }
};

// Two hands that close on a body leave no solution without overlap: the force must stay bounded and the body in place.
TEST(HardContact, BodySqueezedBetweenTwoHandsStaysBetweenThem) {
  HeldBox scene(2);
  for (int i = 0; i < 100; ++i) {
    scene.Step(-0.05);
    ASSERT_LT(glm::length(scene.world.X_WO(scene.box).translation), 1e-4) << i;
    ASSERT_LT(glm::length(scene.world.V_WO(scene.box).linear_m_per_s), 0.06) << i;
  }
}

// As a hand lets go of what its grasp has held: the contacts that were muted when it closed act again when it is open.
// The forces of before, squeezed without a solution, are over; to start from them takes more sweeps than there are.
TEST(HardContact, ContactThatWasMutedActsAgainWithoutItsOldForce) {
  HeldBox scene(20);
  for (int i = 0; i < 20; ++i) scene.Step(-0.05);
  ASSERT_GT(glm::length(scene.world.contact(scene.pairs[0]).F_So_W.force_N), 1000.0) << "nothing was squeezed";
  for (const int pair : scene.pairs) scene.world.SetContactMuted(pair, true);
  for (int i = 0; i < 10; ++i) scene.Step(0.5);
  for (const int pair : scene.pairs) ASSERT_GT(scene.world.SmallestGap_m(pair), 0.001) << "not open";
  const int floor = scene.world.AddContactPair(scene.box, scene.world.world_body(), ContactKind::kHard).value();
  const glm::dvec3 down{0, 0, -HeldBox::kHalf};
  // Apart by 20 mm, but rows: together more than are solved directly.
  core::ContactSet apart = HeldBox::Planes(down, {0, 0, 1}, {0.002, 0, 0}, 20);
  for (core::ContactPlane& plane : apart.planes) plane.q_G.z = static_cast<float>(down.z - 0.02);
  scene.world.SetContactPlanes(floor, apart);
  const core::Twist V = scene.world.V_WO(scene.box);
  for (const int pair : scene.pairs) scene.world.SetContactMuted(pair, false);
  scene.Step(0.0);
  for (const int pair : scene.pairs) EXPECT_EQ(scene.world.contact(pair).num_pushing, 0);
  EXPECT_LT(glm::length(scene.world.V_WO(scene.box).linear_m_per_s - V.linear_m_per_s), 1e-9);
  EXPECT_LT(glm::length(scene.world.V_WO(scene.box).angular_rad_per_s - V.angular_rad_per_s), 1e-9);
}

}  // namespace
}  // namespace physics
