#include <gtest/gtest.h>

#include <filesystem>

#include "core/clock.hpp"
#include "nodes/physics_node/physics_node.hpp"
#include "scene/load_scenario.hpp"

namespace physics_node {
namespace {

class Scenarios : public testing::TestWithParam<const char*> {};

// Without contact every physics-owned object stays at its initial pose: mechanisms start in equilibrium, switches in
// their detents, latched parts in their seats.
TEST_P(Scenarios, StayAtRestUntouched) {
  const std::filesystem::path folder = std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / GetParam();
  const auto scenario = scene::LoadScenario(folder);
  ASSERT_TRUE(scenario.has_value()) << scene::Format(scenario.error().front());
  auto node = PhysicsNode::Create(*scenario);
  ASSERT_TRUE(node.has_value()) << node.error().detail;
  Inputs inputs;
  Outputs outputs;
  (*node)->Step(inputs, &outputs);
  const auto first_mechanisms = outputs.state.mechanisms;
  for (int i = 0; i < 3000; ++i) (*node)->Step(inputs, &outputs);
  for (const core::BodyState& body : outputs.state.bodies) {
    const scene::Object& object = scenario->objects[body.object];
    EXPECT_LT(glm::length(body.X_WO.translation - object.X_WO.translation), 2e-4) << object.name;
    EXPECT_LT(glm::length(body.V_WO.linear_m_per_s), 1e-4) << object.name;
    EXPECT_LT(glm::length(core::RotationVector(body.X_WO.rotation * glm::conjugate(object.X_WO.rotation))), 2e-3)
        << object.name;
  }
  for (std::size_t i = 0; i < outputs.state.mechanisms.size(); ++i) {
    EXPECT_EQ(outputs.state.mechanisms[i].state, first_mechanisms[i].state) << scenario->mechanisms[i].name;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Scenarios,
                         testing::Values("touch", "peg_in_hole", "module_replacement", "service_robot"));

}  // namespace
}  // namespace physics_node
