#include <gtest/gtest.h>

#include "core/clock.hpp"
#include "nodes/physics_node/physics_node.hpp"

namespace physics_node {
namespace {

// A free block in a latch on a wall, pushed aside: it swings on the latch's lateral springs.
struct Swing {
  static constexpr double kStiffness = 2.0e3;  // N/m
  scene::Scenario scenario;
  std::unique_ptr<PhysicsNode> node;
  Inputs inputs;
  Outputs outputs;
  std::vector<core::Event> events;

  Swing() {
    scene::Object wall;
    wall.name = "wall";
    scene::Object block;
    block.name = "block";
    block.owner = scene::Owner::kPhysics;
    block.V_WO.linear_m_per_s = {0.02, 0.0, 0.0};
    scenario.objects = {wall, block};
    scene::Mechanism latch;
    latch.name = "latch";
    latch.kind = scene::MechanismKind::kSnap;
    latch.parent = 0;
    latch.child = 1;
    latch.engage_force_N = 10.0;
    latch.release_force_N = 30.0;
    latch.stiffness_N_per_m = kStiffness;
    latch.stiffness_Nm_per_rad = 40.0;
    latch.is_initially_engaged = true;
    scenario.mechanisms = {latch};
    node = Make();
  }
  [[nodiscard]] std::unique_ptr<PhysicsNode> Make() const {
    const std::vector<physics::MassProperties> masses(2, physics::BoxMass(0.5, glm::dvec3(0.04)));
    auto created = PhysicsNode::Create(scenario, masses);
    EXPECT_TRUE(created.has_value()) << (created ? "" : created.error().detail);
    return std::move(*created);
  }
  void Tick(const core::ParameterChange* change = nullptr) {
    inputs.now_ns += core::kTick_ns;
    inputs.changes = change;
    inputs.num_changes = change != nullptr ? 1 : 0;
    node->Step(inputs, &outputs);
    events.insert(events.end(), outputs.events.begin(), outputs.events.end());
  }
  void Run(int ticks) {
    for (int i = 0; i < ticks; ++i) Tick();
  }
  [[nodiscard]] double offset_m() const { return outputs.state.bodies[0].X_WO.translation.x; }
};

TEST(LiveChange, AnImmediateChangeReportsItsInjectedEnergy) {
  Swing swing;
  swing.Run(15);
  const double x_m = swing.offset_m();
  ASSERT_GT(x_m, 1e-4);
  const core::ParameterChange change{"latch.stiffness_N_per_m", 3.0 * Swing::kStiffness};
  swing.Tick(&change);
  ASSERT_EQ(swing.outputs.outcomes.size(), 1u);
  EXPECT_TRUE(swing.outputs.outcomes[0].is_accepted);
  EXPECT_FALSE(swing.outputs.outcomes[0].is_pending);
  const double expected_J = Swing::kStiffness * x_m * x_m;  // 2 k x^2 / 2
  EXPECT_NEAR(swing.outputs.outcomes[0].injected_J, expected_J, 1e-6 * expected_J);
  EXPECT_TRUE(swing.events.empty());
}

TEST(LiveChange, ARampReportsItsEndOnceWithTickAndEnergy) {
  Swing swing;
  swing.Run(15);
  const core::ParameterChange change{"latch.stiffness_N_per_m", 3.0 * Swing::kStiffness, core::ChangeManner::kRamped,
                                     0.01};
  swing.Tick(&change);
  EXPECT_TRUE(swing.outputs.outcomes[0].is_pending);
  swing.Run(20);
  ASSERT_EQ(swing.events.size(), 1u);
  EXPECT_EQ(swing.events[0].name, "parameter_settled");
  EXPECT_EQ(swing.events[0].detail.find("latch.stiffness_N_per_m settled at tick 25, injected "), 0u)
      << swing.events[0].detail;
}

TEST(LiveChange, AChangeHeldUntilSeparationInjectsNoEnergy) {
  Swing swing;
  swing.Run(15);
  const core::ParameterChange change{"latch.stiffness_N_per_m", 0.0, core::ChangeManner::kWhenSeparated};
  swing.Tick(&change);
  EXPECT_TRUE(swing.outputs.outcomes[0].is_pending);
  const core::ParameterChange let_go{"latch.release_force_N", 0.0};
  swing.Tick(&let_go);
  swing.Run(2000);
  ASSERT_FALSE(swing.events.empty());
  EXPECT_EQ(swing.events.back().name, "parameter_settled");
}

TEST(LiveChange, RefusesInvalidValuesAndManners) {
  Swing swing;
  using enum core::ChangeManner;
  EXPECT_TRUE(swing.node->AcceptsParameter({"latch.damping", 3.0, kRamped, 1.0}));
  EXPECT_FALSE(swing.node->AcceptsParameter({"latch.damping", -3.0}));
  EXPECT_FALSE(swing.node->AcceptsParameter({"latch.damping", 3.0, kRamped, -1.0}));
  EXPECT_FALSE(swing.node->AcceptsParameter({"latch.travel_m", 3.0}));
  const core::ParameterChange refused{"latch.damping", -3.0};
  swing.Tick(&refused);
  EXPECT_FALSE(swing.outputs.outcomes[0].is_accepted);
}

// A node restored in the middle of a ramp ends it at the same tick and in the same state.
TEST(LiveChange, ARampContinuesInARestoredNode) {
  Swing swing;
  swing.Run(15);
  const core::ParameterChange change{"latch.stiffness_N_per_m", 3.0 * Swing::kStiffness, core::ChangeManner::kRamped,
                                     0.02};
  swing.Tick(&change);
  swing.Run(5);
  Snapshot snapshot;
  swing.node->Save(&snapshot);
  Swing restored;
  ASSERT_TRUE(restored.node->Restore(&snapshot).has_value());
  for (int i = 0; i < 40; ++i) {
    swing.Tick();
    restored.Tick();
    ASSERT_EQ(swing.outputs.state.state_hash, restored.outputs.state.state_hash) << i;
  }
  ASSERT_EQ(restored.events.size(), 1u);
  EXPECT_EQ(restored.events[0].detail, swing.events[0].detail);
}

}  // namespace
}  // namespace physics_node
