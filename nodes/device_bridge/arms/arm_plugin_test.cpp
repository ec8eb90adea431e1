#include "nodes/device_bridge/arms/arm_plugin.hpp"

#include <gtest/gtest.h>

#include "nodes/device_bridge/arms/simulated_arm.hpp"
#include "nodes/device_bridge/devices/plugin_table.hpp"
#include "nodes/device_bridge/devices/plugin_values.hpp"

namespace device_bridge {
namespace {

// Through texts and the table of device/plugin.h an arm moves as the class by itself does, to the last bit: runs in
// lock-step do not depend on how a device is called.
TEST(ArmPlugin, IsTheSimulatedArmBitByBit) {
  for (const char* type : {"simulated_arm", "simulated_hug"}) {
    scene::Device figures;
    figures.role = "right";
    figures.type = type;
    figures.mass_kg = 1.0 / 0.7;
    figures.command_delay_s = 0.0013;
    figures.X_WD_start = {core::QuaternionFromRollPitchYaw({0.1, 0.2, 0.3}), {0.1, -0.2, 1.0 / 3.0}};
    SimulatedArm alone(ArmParameters::From(figures));
    const auto table = FindPlugin(type, "");
    ASSERT_TRUE(table);
    char why[100];
    const DeviceSetting setting(figures);
    const oos_device_setting view = setting.View(why, sizeof why);
    void* device = nullptr;
    ASSERT_EQ(table->functions->open(&view, &device), OOS_DEVICE_OK);
    oos_device_state state{};
    for (int i = 1; i <= 400; ++i) {
      const std::int64_t now_ns = i * 1'000'000;
      oos_device_command command{};
      command.F_Do_B[i % 6] = 0.3 * (i % 7);
      command.grip_force_N = 0.1 * (i % 5);
      oos_device_hand hand{};
      HandTarget target;
      target.X_WT = figures.X_WD_start;
      target.X_WT.translation.x += 1e-4 * i;
      target.V_WT.linear_m_per_s.x = 0.1;
      ToArray(target.X_WT, hand.X_BT);
      ToArray(target.V_WT, hand.V_BT);
      hand.grip_strength_N = target.grip_strength_N;
      hand.holds_dead_man = 1;
      alone.Read(now_ns);
      alone.Write(now_ns, {WrenchOf(command.F_Do_B), command.grip_force_N, 0.0, 0.0});
      alone.SetHand(target);
      table->functions->step(device, now_ns, &command, nullptr, &state);
      table->functions->step(device, now_ns, nullptr, &hand, &state);
      const DeviceReading reading = alone.Read(now_ns);
      double pose[7], twist[6];
      ToArray(reading.X_WD, pose);
      ToArray(reading.V_WD, twist);
      for (int k = 0; k < 7; ++k) ASSERT_EQ(state.X_BD[k], pose[k]) << type << " " << i;
      for (int k = 0; k < 6; ++k) ASSERT_EQ(state.V_BD[k], twist[k]) << type << " " << i;
      ASSERT_EQ(state.opening_m, reading.opening_m);
      ASSERT_EQ(state.hand_F_Do_B[0], alone.Felt().hand_F_Do_W.force_N.x);
    }
    table->functions->close(device);
  }
}

}  // namespace
}  // namespace device_bridge
