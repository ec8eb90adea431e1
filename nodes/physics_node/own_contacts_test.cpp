#include "nodes/physics_node/own_contacts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "collision/resolution/choose_resolutions.hpp"
#include "core/clock.hpp"
#include "nodes/physics_node/physics_node.hpp"

namespace physics_node {
namespace {

scene::Scenario FreeCollision() {
  const auto scenario =
      collision::LoadResolvedScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / "free_collision");
  EXPECT_TRUE(scenario.has_value());
  return *scenario;
}

struct Collision {
  explicit Collision(const scene::Scenario& scenario) : node(std::move(*PhysicsNode::Create(scenario))) {}
  // Runs until the bodies have collided and separated; returns whether they have.
  bool Run() {
    for (int tick = 0; tick < 2000; ++tick) {
      node->Step(inputs, &outputs);
      ticks_in_contact += outputs.state.is_in_contact ? 1 : 0;
      last_contact = outputs.state.is_in_contact ? tick : last_contact;
      if (ticks_in_contact > 0 && tick > last_contact + 100) return true;
    }
    return false;
  }
  [[nodiscard]] glm::dvec3 momentum_Ns() const { return node->world().momentum_Ns(1) + node->world().momentum_Ns(2); }
  [[nodiscard]] double energy_J() const {
    return node->world().kinetic_energy_J(1) + node->world().kinetic_energy_J(2);
  }
  std::unique_ptr<PhysicsNode> node;
  Inputs inputs;
  Outputs outputs;
  int ticks_in_contact = 0;
  int last_contact = 0;
};

// Without haptic_node: the contact is computed by physics_node.
TEST(OwnContacts, TwoFreeBodiesReboundAndKeepTheirMomentum) {
  Collision collision(FreeCollision());
  collision.node->Step(collision.inputs, &collision.outputs);
  const glm::dvec3 before_Ns = collision.momentum_Ns();
  const double before_J = collision.energy_J();
  ASSERT_TRUE(collision.Run());
  EXPECT_LT(glm::length(collision.momentum_Ns() - before_Ns), 1e-12);
  EXPECT_LT(collision.node->impulse_balance().relative(), 1e-9);
  const core::BodyState& mover = collision.outputs.state.bodies[0];
  const core::BodyState& target = collision.outputs.state.bodies[1];
  EXPECT_GT(target.V_WO.linear_m_per_s.x - mover.V_WO.linear_m_per_s.x, 0.05) << "they part";
  EXPECT_NEAR(std::sqrt(collision.energy_J() / before_J), 1.0, 0.03) << "undamped: next to nothing is lost or gained";
}

TEST(OwnContacts, WithoutAnActivePairTheBodyPassesThrough) {
  scene::Scenario scenario = FreeCollision();
  scenario.pairs[0].is_active = false;
  Collision collision(scenario);
  EXPECT_FALSE(collision.Run());
  EXPECT_EQ(collision.outputs.state.bodies[1].V_WO.linear_m_per_s, glm::dvec3(0.0));
}

TEST(OwnContacts, DoesNotComputePairsOfTheHapticNode) {
  scene::Scenario scenario = FreeCollision();
  scenario.pairs[0].owner = scene::PairOwner::kHaptic;
  Collision collision(scenario);
  EXPECT_EQ(collision.node->own_contacts().num_pairs(), 0u);
  EXPECT_FALSE(collision.Run());
}

// With 50 free parts 3 m away, each with pairs to everything, the contact of the moving body needs exactly the same
// number of sphere tests, and both bodies move bit for bit as without them.
TEST(OwnContacts, DistantPartsAddNoWork) {
  const scene::Scenario scenario = FreeCollision();
  scene::Scenario crowded = scenario;
  const auto add_pair = [&](std::size_t sampled, std::size_t field) {
    scene::Pair pair = scenario.pairs[0];
    pair.sampled = static_cast<std::uint16_t>(sampled);
    pair.field = static_cast<std::uint16_t>(field);
    crowded.pairs.push_back(pair);
  };
  for (int i = 0; i < 50; ++i) {
    scene::Object part = scenario.objects[1];
    part.name = "part_" + std::to_string(i);
    part.X_WO.translation = {0.2 * i, 3.0, 0.0};
    for (std::size_t j = 0; j < crowded.objects.size(); ++j) add_pair(j, crowded.objects.size());
    crowded.objects.push_back(part);
  }
  ASSERT_TRUE(collision::ChooseResolutions(&crowded)) << "each is a field and sampled now";
  Collision few(scenario);
  Collision many(crowded);
  bool has_met = false;
  for (int tick = 0; tick < 560; ++tick) {
    few.node->Step(few.inputs, &few.outputs);
    many.node->Step(many.inputs, &many.outputs);
    const vps::StepReport& one = few.node->own_contacts().report();
    const vps::StepReport& all = many.node->own_contacts().report();
    has_met = has_met || few.outputs.state.is_in_contact;
    if (tick > 0) {  // the first tick tests every pair
      ASSERT_EQ(all.pairs_tested, one.pairs_tested) << tick;
      ASSERT_EQ(all.pairs_bounded, one.pairs_bounded) << tick;
    }
    ASSERT_EQ(all.counters.spheres_tested, one.counters.spheres_tested) << tick;
    ASSERT_EQ(all.counters.points_tested, one.counters.points_tested) << tick;
    for (int body = 0; body < 2; ++body) {
      ASSERT_EQ(many.outputs.state.bodies[body].X_WO.translation, few.outputs.state.bodies[body].X_WO.translation);
    }
  }
  EXPECT_TRUE(has_met);
}

// During contact the published sets belong to the tick; then a few empty ones mark its end.
TEST(OwnContacts, PublishesItsPlanesAndTheEndOfTheContact) {
  Collision collision(FreeCollision());
  int num_with_planes = 0;
  int num_empty = 0;
  for (int tick = 0; tick < 1500; ++tick) {
    collision.node->Step(collision.inputs, &collision.outputs);
    const OwnContacts& own = collision.node->own_contacts();
    if (!own.is_published(0)) continue;
    EXPECT_EQ(own.set(0).cycle, collision.outputs.state.tick);
    ++(own.set(0).planes.empty() ? num_empty : num_with_planes);
  }
  EXPECT_GT(num_with_planes, 10);
  EXPECT_EQ(num_empty, 5);
}

TEST(OwnContacts, TheCollisionMatrixSaysHowDeepAndWithWhichForceOfTheSolver) {
  Collision collision(FreeCollision());
  core::CollisionMatrix matrix;
  collision.node->Step(collision.inputs, &collision.outputs);
  collision.node->FillCollisions(&matrix);
  EXPECT_EQ(matrix.num_touching, 0U);
  while (!collision.outputs.state.is_in_contact) collision.node->Step(collision.inputs, &collision.outputs);
  for (int i = 0; i < 5; ++i) collision.node->Step(collision.inputs, &collision.outputs);
  const glm::dvec3 before_Ns = collision.node->world().momentum_Ns(1);
  collision.node->Step(collision.inputs, &collision.outputs);
  collision.node->FillCollisions(&matrix);
  ASSERT_EQ(matrix.collisions.size(), 1U);
  EXPECT_EQ(matrix.cycle, collision.outputs.state.tick);
  EXPECT_GT(matrix.collisions[0].depth_m, 0.0F);
  const double force_N = glm::length(collision.node->world().momentum_Ns(1) - before_Ns) / core::kTick_s;
  EXPECT_NEAR(matrix.collisions[0].force_N, force_N, 1e-3 * force_N);
}

TEST(OwnContacts, ReportsTheEnergyOfAStiffnessChangeInContact) {
  Collision collision(FreeCollision());
  while (!collision.outputs.state.is_in_contact) collision.node->Step(collision.inputs, &collision.outputs);
  for (int i = 0; i < 10; ++i) collision.node->Step(collision.inputs, &collision.outputs);
  const core::ParameterChange change{"pair.mover/target.stiffness_N_per_m", 40000.0};
  collision.inputs.changes = &change;
  collision.inputs.num_changes = 1;
  collision.node->Step(collision.inputs, &collision.outputs);
  ASSERT_EQ(collision.outputs.outcomes.size(), 1u);
  EXPECT_GT(collision.outputs.outcomes[0].injected_J, 0.0);
}

}  // namespace
}  // namespace physics_node
