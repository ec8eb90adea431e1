#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/clock.hpp"
#include "nodes/device_bridge/allowed_coupling.hpp"
#include "nodes/device_bridge/loop_delay.hpp"
#include "nodes/device_bridge/passivity.hpp"
#include "nodes/device_bridge/testing/toy_world.hpp"
#include "stability/sampled_axis.hpp"

namespace device_bridge {
namespace {

TEST(LoopDelay, GivesMeanAndMeanDeviation) {
  LoopDelay delay(0.5e-3);
  EXPECT_FALSE(delay.is_measured());
  for (int i = 0; i < 5000; ++i) delay.Add(i % 2 == 0 ? 1'000'000 : 1'400'000);
  EXPECT_NEAR(delay.mean_s(), 1.7e-3, 1e-6) << "with the device's own 0.5 ms";
  EXPECT_NEAR(delay.jitter_s(), 0.2e-3, 2e-6);
  EXPECT_NEAR(delay.late_s(), 2.1e-3, 5e-6);
}

TEST(LoopDelay, OneLateForceHardlyCountsAndASlowLoopDoes) {
  LoopDelay delay(0.0);
  for (int i = 0; i < 2000; ++i) delay.Add(300'000);
  delay.Add(20'000'000);
  EXPECT_LT(delay.late_s(), 0.45e-3);
  for (int i = 0; i < 2000; ++i) delay.Add(2'000'000);
  EXPECT_GT(delay.late_s(), 1.9e-3);
}

TEST(AllowedCoupling, IsTheExactBoundaryOfEachAxis) {
  const scene::Device device;
  const scene::Coupling wanted;
  for (const double delay_s : {0.3e-3, 1e-3, 2.8e-3, 10e-3}) {
    const AllowedCoupling allowed = ComputeAllowedCoupling(device, wanted, {}, delay_s);
    const stability::SampledAxis turn{device.inertia_kg_m2, device.damping_Nm_s_per_rad, 1e-3, delay_s};
    EXPECT_EQ(allowed.stiffness_Nm_per_rad, stability::MaxStiffness(turn, 0.0));
    const stability::SampledAxis axis{device.mass_kg, device.damping_N_s_per_m, 1e-3, delay_s};
    EXPECT_NEAR(allowed.share,
                std::min(allowed.stiffness_N_per_m / wanted.stiffness_N_per_m,
                         allowed.stiffness_Nm_per_rad / wanted.stiffness_Nm_per_rad),
                1e-6 * allowed.share);
    const double K = std::min(1.0, 0.99 * allowed.share) * wanted.stiffness_N_per_m;
    EXPECT_TRUE(stability::IsStable(axis, {K, 0.999 * allowed.damping_N_s_per_m})) << delay_s;
    EXPECT_FALSE(stability::IsStable(axis, {K, 1.01 * allowed.damping_N_s_per_m})) << delay_s;
  }
}

TEST(AllowedCoupling, TheDefaultCouplingIsAllowedOnTheDefaultDeviceAtOneMillisecond) {
  const AllowedCoupling allowed = ComputeAllowedCoupling({}, {}, {}, 1e-3);
  EXPECT_GT(allowed.stiffness_N_per_m, scene::Coupling{}.stiffness_N_per_m);
  EXPECT_GT(allowed.stiffness_Nm_per_rad, scene::Coupling{}.stiffness_Nm_per_rad);
}

// A lever r couples the translation across it with the rotation about the third axis. With x in units of 1/sqrt(m) and
// phi in units of 1/sqrt(I), M^-1 K is there
//   ( k/m           k r/sqrt(m I)   )
//   ( k r/sqrt(m I) (k_t + k r^2)/I ),
// whose larger eigenvalue is in closed form. Damping in proportion to the mass is the same for every mode.
TEST(AllowedCoupling, ALeverLowersTheShareToThatOfTheStiffestMode) {
  scene::Device device;
  device.damping_Nm_s_per_rad = device.damping_N_s_per_m * device.inertia_kg_m2 / device.mass_kg;
  const scene::Coupling wanted;
  const glm::dvec3 lever_D(0.03, -0.06, 0.08);
  const double r2 = glm::dot(lever_D, lever_D);
  const double a = wanted.stiffness_N_per_m / device.mass_kg;
  const double b = (wanted.stiffness_Nm_per_rad + wanted.stiffness_N_per_m * r2) / device.inertia_kg_m2;
  const double c2 = wanted.stiffness_N_per_m * wanted.stiffness_N_per_m * r2 / (device.mass_kg * device.inertia_kg_m2);
  const double stiffest_per_s2 = 0.5 * (a + b) + std::sqrt(0.25 * (a - b) * (a - b) + c2);
  for (const double delay_s : {0.3e-3, 2.8e-3}) {
    const stability::SampledAxis unit{1.0, device.damping_N_s_per_m / device.mass_kg, 1e-3, delay_s};
    const double expected = stability::MaxStiffness(unit, 0.0) / stiffest_per_s2;
    const double share = ComputeAllowedCoupling(device, wanted, lever_D, delay_s).share;
    EXPECT_NEAR(share / expected, 1.0, 1e-6) << delay_s;
    EXPECT_LT(share, 0.7 * ComputeAllowedCoupling(device, wanted, {}, delay_s).share) << delay_s;
  }
}

TEST(DeviceBridge, MeasuresTheDelayOfItsLoopAndWhatItAllows) {
  ToyWorld world("step a\nwait 100\n", 1,
                 [](scene::Scenario& scenario) { scenario.devices[0].command_delay_s = 0.8e-3; });
  world.Run(0.5);
  const RoleFigures figures = world.bridge->figures(0);
  EXPECT_NEAR(figures.loop_delay_s, 1.8e-3, 1e-9);
  EXPECT_NEAR(figures.loop_jitter_s, 0.0, 1e-9);
  const scene::Device device;
  const stability::SampledAxis axis{device.mass_kg, device.damping_N_s_per_m, 1e-3, 1.8e-3};
  EXPECT_NEAR(figures.allowed.stiffness_N_per_m / stability::MaxStiffness(axis, 0.0), 1.0, 1e-6);
  EXPECT_NEAR(figures.least_stiffness_share,
              std::min(figures.allowed.stiffness_N_per_m / 2500.0, figures.allowed.stiffness_Nm_per_rad / 30.0), 1e-12);
}

// haptic_node sends a sample's force a second time when physics has answered; the loop has closed with the first. If
// the second is made of a newer sample, it is that one's first.
TEST(DeviceBridge, ASamplesReevaluatedForceDoesNotLengthenTheMeasuredDelay) {
  ToyWorld world("step a\nwait 100\n");
  Inputs inputs;
  Outputs outputs;
  std::uint64_t sequence = 0;
  const auto answer = [&](const core::DeviceState& sample, std::int64_t now_ns) {
    core::DeviceCommand command;
    command.header.sequence = ++sequence;
    command.header.direct = sample.header.direct;
    world.bridge->AcceptCommand(0, command, now_ns, now_ns);
  };
  core::DeviceState before;
  for (int tick = 1; tick <= 500; ++tick) {
    inputs.now_ns = tick * core::kTick_ns;
    world.bridge->Step(inputs, &outputs);
    if (tick % 2 == 0) answer(before, inputs.now_ns + 100'000);  // late, of the sample before
    answer(outputs.states[0], inputs.now_ns + 300'000);
    answer(outputs.states[0], inputs.now_ns + 700'000);
    before = outputs.states[0];
  }
  EXPECT_NEAR(world.bridge->figures(0).loop_delay_s, 0.3e-3, 1e-9);
  EXPECT_NEAR(world.bridge->figures(0).loop_jitter_s, 0.0, 1e-9);
}

// Presses into a stiff wall and lets go, over and over; the wall's force is that of the last tick and so returns more
// than it took.
ToyWorld Hammering(double wall_N_per_m, double damping_N_s_per_m) {
  ToyWorld world("step a\nwait 1.2\npush 0 0 -1 by 0.05 speed 0.05\nwait 100\n");
  world.contact = [=](const core::DeviceState& state) {
    const double depth_m = -0.02 - state.X_WD.translation.z;
    if (depth_m <= 0.0) return core::Wrench{};
    const double force_N = wall_N_per_m * depth_m - damping_N_s_per_m * state.V_WD.linear_m_per_s.z;
    return core::Wrench{{0, 0, std::max(0.0, force_N)}, {0, 0, 0}};
  };
  world.Run(8.0);
  return world;
}

TEST(Passivity, DoesNotActOnADampedWall) {
  const RoleFigures figures = Hammering(5000.0, 30.0).bridge->figures(0);
  EXPECT_GT(figures.energy_J, 0.0);
  EXPECT_EQ(figures.samples_made_passive, 0U);
}

TEST(Passivity, ReturnsNoMoreEnergyThanTheHandGave) {
  const RoleFigures figures = Hammering(60000.0, 0.0).bridge->figures(0);
  EXPECT_GT(figures.samples_made_passive, 0U) << "the wall is unstable";
  EXPECT_GT(figures.least_energy_J, -0.2);
}

// A weight of 5 N hangs on the hand, which lowers it by 50 mm: it gets a quarter of a joule that it has not put in.
RoleFigures Lowering(bool is_weight_known) {
  constexpr double kWeight_N = 5.0;
  ToyWorld world("step a\nwait 1.5\npush 0 0 -1 by 0.05 speed 0.1\nwait 100\n", 1, [=](scene::Scenario& scenario) {
    if (is_weight_known) scenario.gravity_m_per_s2 = {0.0, 0.0, -10.0};
    for (scene::Object& object : scenario.objects) {
      object.mass_kg = 0.1 * kWeight_N;
      object.inertia.emplace();
    }
  });
  world.contact = [](const core::DeviceState&) { return core::Wrench{{0, 0, -kWeight_N}, {0, 0, 0}}; };
  world.after = [](ToyWorld& w) { w.physics.bodies[0].X_WO = w.outputs.states[0].X_WD; };
  world.Run(4.0);
  return world.bridge->figures(0);
}

TEST(Passivity, LetsAHandLowerWhatHasWeight) {
  EXPECT_LT(Lowering(true).energy_J, -0.2);
  EXPECT_EQ(Lowering(true).samples_made_passive, 0U);
  EXPECT_GT(Lowering(false).samples_made_passive, 100U);
}

TEST(Passivity, CountsTheWorkOverTheWayThatTheDeviceMoved) {
  Passivity passivity{{}};
  SafetyFilter filter = *SafetyFilter::Create([] {
    FilterLimits limits;
    limits.start_ramp_ns = 0;
    limits.max_force_rate_N_per_s = 1e6;
    return limits;
  }());
  DeviceReading reading;
  reading.is_engaged = true;
  filter.Apply(0, reading);
  core::DeviceCommand command;
  command.header.sequence = 1;
  command.F_Do_W = {{10, 0, 0}, {0, 0, 2}};
  filter.Accept(command, 1'000'000);
  const core::Wrench acted = filter.Apply(1'000'000, reading).F_Do_W();
  ASSERT_NEAR(acted.force_N.x, 10.0, 1e-9);
  passivity.Step(reading, {}, true);
  reading.X_WD.translation.x = -0.01;                                        // the hand pushes against the force
  reading.X_WD.rotation = core::QuaternionFromRotationVector({0, 0, 0.02});  // and is turned by the torque
  EXPECT_EQ(passivity.Step(reading, acted, true).force_N, glm::dvec3(0.0));
  EXPECT_NEAR(passivity.energy_J(), 0.1 - 0.04, 1e-12);
  reading.X_WD.translation.x = 0.0;
  reading.V_WD.linear_m_per_s = {0.5, 0, 0};
  const core::Wrench damping = passivity.Step(reading, acted, true);
  EXPECT_NEAR(passivity.energy_J(), -0.04, 1e-12);
  EXPECT_NEAR(damping.force_N.x, -100.0 * 1.5 * 0.5, 1e-9) << "capped";
  // Another hand has put that much in, and the world returns it here: who holds a part feels the other push it.
  EXPECT_EQ(passivity.Step(reading, acted, true, 0.05).force_N, glm::dvec3(0.0));
  EXPECT_NE(passivity.Step(reading, acted, true, 0.03).force_N, glm::dvec3(0.0));
  passivity.Step(reading, acted, false);
  EXPECT_NEAR(passivity.energy_J(), 0.5 * 100.0 / 2500.0 + 0.5 * 4.0 / 30.0, 1e-12);
}

}  // namespace
}  // namespace device_bridge
