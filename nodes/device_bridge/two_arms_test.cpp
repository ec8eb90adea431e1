#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>

#include "hug/machine.hpp"
#include "nodes/device_bridge/device_bridge.hpp"
#include "stability/sampled_axis.hpp"

namespace device_bridge {
namespace {

constexpr double kDelay_s = 1e-3;  // a tick from sample to force

// A bridge with both arms of a simulated HUG, whose hands hold them softly. `wall_N_per_m` on the way of each hand
// along z; its force is late by a tick.
struct TwoArms {
  scene::Scenario scenario;
  std::unique_ptr<DeviceBridge> bridge;
  Inputs inputs;
  Outputs outputs;
  std::int64_t now_ns = 1'000'000'000;
  std::uint64_t sequence = 0;
  double wall_N_per_m = 0.0, wall_N_s_per_m = 0.0, kick_N = 0.0;
  double z_m[2] = {}, before_m[2] = {}, furthest_m = 0.0, largest_N = 0.0;

  explicit TwoArms(bool is_made_passive) {
    scenario.name = "two_arms";
    for (const char* role : {"right", "left"}) {
      scene::Device device;
      device.role = role;
      device.type = "hug";
      device.X_WD_start.translation = {role[0] == 'r' ? 0.3 : -0.3, 0.07, 0.25};
      device.hand_stiffness_N_per_m = device.hand_stiffness_Nm_per_rad = 1e-3;
      device.hand_damping_N_s_per_m = device.hand_damping_Nm_s_per_rad = 0.0;
      for (const auto& [name, value] : {std::pair{"hug_x_m", "0"}, {"hug_y_m", "-0.53"}, {"hug_z_m", "0.05"}}) {
        device.options.emplace_back(name, value);
      }
      scenario.devices.push_back(device);
    }
    scenario.operator_script = ::testing::TempDir() + "device_bridge_two_arms.txt";
    std::ofstream(scenario.operator_script) << "";
    Options options;
    options.is_made_passive = is_made_passive;
    auto made = DeviceBridge::Create(scenario, 1, options);
    EXPECT_TRUE(made) << made.error().detail;
    if (made) bridge = std::move(*made);
    Run(4000);
    for (int i = 0; i < 2; ++i) z_m[i] = before_m[i] = outputs.states[static_cast<std::size_t>(i)].X_WD.translation.z;
  }
  void Run(int ticks) {
    core::DeviceCommand commands[2];
    for (int t = 0; t < ticks; ++t) {
      now_ns += 1'000'000;
      inputs.now_ns = now_ns;
      bridge->Step(inputs, &outputs);
      inputs.commands.clear();
      inputs.command_received_ns.clear();
      ++sequence;
      for (std::size_t i = 0; i < 2; ++i) {
        const core::DeviceState& state = outputs.states[i];
        commands[i].header.sequence = sequence;
        commands[i].header.direct = state.header.direct;
        commands[i].role_index = static_cast<std::uint8_t>(i);
        const double now_m = state.X_WD.translation.z;
        commands[i].F_Do_W.force_N.z =
            kick_N - wall_N_per_m * (now_m - z_m[i]) - wall_N_s_per_m * (now_m - before_m[i]) / 1e-3;
        before_m[i] = now_m;
        largest_N = std::max(largest_N, glm::length(outputs.applied[i].force_N));
        furthest_m = std::max(furthest_m, std::abs(now_m - z_m[i]));
        inputs.commands.push_back(commands[i]);
        inputs.command_received_ns.push_back(now_ns);
      }
    }
  }
  // Apparent mass of an arm along z: 30 % of the links' and rotors', and what is mounted beyond the sensor.
  static double Mass_kg() {
    hug::Machine machine{hug::MachineFigures{}};
    hug::ArmFigures figures;
    figures.mount.mass_kg = 0.0;
    EXPECT_TRUE(machine.Open(hug::Side::kRight, figures, {{1, 0, 0, 0}, {0.6, -0.3, 0.2}}));
    hug::ArmDynamics arm = machine.arm(hug::Side::kRight).measured();
    return 0.3 / arm.InverseApparentInertia()[5][5] + hug::HandMount{}.mass_kg;
  }
};

// A wall that is a tenth too stiff for both arms. Without the passivity controller the hands soon swing at the force
// limit; with it the swing is over within 200 ms.
TEST(TwoArms, AnUnstableWallIsCaughtWithin200msBelowTheForceLimit) {
  const stability::SampledAxis axis{TwoArms::Mass_kg(), 0.0, 1e-3, kDelay_s};
  for (const bool is_made_passive : {false, true}) {
    TwoArms arms(is_made_passive);
    arms.wall_N_s_per_m = 0.2 * 0.828 * axis.mass_kg / 1e-3;
    arms.wall_N_per_m = 1.1 * stability::MaxStiffness(axis, arms.wall_N_s_per_m);
    arms.kick_N = 10.0;
    arms.Run(20);
    arms.kick_N = 0.0;
    arms.Run(180);
    arms.largest_N = arms.furthest_m = 0.0;
    arms.Run(2000);
    for (std::size_t role = 0; role < 2; ++role) {
      EXPECT_EQ(arms.bridge->figures(role).samples_over_limit, 0U);
    }
    if (is_made_passive) {
      EXPECT_LT(arms.largest_N, 10.0);
      EXPECT_LT(arms.furthest_m, 0.001);
    } else {
      EXPECT_GT(arms.largest_N, 30.0);
    }
  }
}

}  // namespace
}  // namespace device_bridge
