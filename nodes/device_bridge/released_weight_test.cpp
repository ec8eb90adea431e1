#include "nodes/device_bridge/released_weight.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace device_bridge {
namespace {

constexpr double kG = 10.0;

// A part of 0.2 kg, and a sheet of 0.06 kg whose middle is 0.1 m above the part's own.
scene::Scenario PartWithSheet() {
  scene::Scenario scenario;
  scenario.gravity_m_per_s2 = {0.0, 0.0, -kG};
  scene::Object part;
  part.owner = scene::Owner::kPhysics;
  part.mass_kg = 0.2;
  part.inertia.emplace();
  part.sheet.emplace();
  part.sheet->size_x_m = 0.4;
  part.sheet->size_y_m = 0.3;
  part.sheet->density_kg_per_m2 = 0.5;
  part.sheet->X_OS.translation = {0.0, 0.0, 0.1};
  scenario.objects.push_back(part);
  return scenario;
}

double Released_J(const scene::Scenario& scenario, const core::Pose& X_WO) {
  auto weight = ReleasedWeight::Create(scenario);
  EXPECT_TRUE(weight) << weight.error().detail;
  core::PhysicsState state;
  state.bodies.push_back({0, {}, {}});
  weight->Update(state);
  state.bodies[0].X_WO = X_WO;
  for (int i = 0; i < 2; ++i) weight->Update(state);  // at rest again: nothing is led
  return weight->energy_J();
}

const core::Pose kLower{{1, 0, 0, 0}, {0.3, 0.0, -0.5}};

TEST(ReleasedWeight, CountsASheetWithThePartThatItIsSewnTo) {
  EXPECT_NEAR(Released_J(PartWithSheet(), kLower), 0.26 * kG * 0.5, 1e-12);
  const core::Pose X_WO{glm::angleAxis(std::numbers::pi, glm::dvec3(1, 0, 0)), {}};
  EXPECT_NEAR(Released_J(PartWithSheet(), X_WO), 0.06 * kG * 0.2, 1e-12);
}

TEST(ReleasedWeight, LeavesOutASheetThatIsNotActive) {
  scene::Scenario scenario = PartWithSheet();
  scenario.objects[0].sheet->is_active = false;
  EXPECT_NEAR(Released_J(scenario, kLower), 0.2 * kG * 0.5, 1e-12);
}

}  // namespace
}  // namespace device_bridge
