#include "nodes/device_bridge/arms/simulated_arm.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/clock.hpp"
#include "nodes/device_bridge/arms/arm_plugin.hpp"
#include "nodes/device_bridge/safety_filter.hpp"
#include "stability/sampled_axis.hpp"

namespace device_bridge {
namespace {

// Creates forces through a filter with the widest limits and without ramps.
class Motor {
 public:
  Motor() : filter_(*SafetyFilter::Create(WideOpen())) { filter_.Apply(-10 * core::kMillisecond_ns, Held()); }

  MotorForce Force(std::int64_t now_ns, const glm::dvec3& force_N, const glm::dvec3& torque_Nm = glm::dvec3(0.0),
                   double grip_N = 0.0) {
    core::DeviceCommand command;
    command.header.sequence = ++sequence_;
    command.F_Do_W = {force_N, torque_Nm};
    command.grip_force_N = grip_N;
    filter_.Accept(command, now_ns);
    const FilteredForce force = filter_.Apply(now_ns, Held());
    return {force.F_Do_W(), force.grip_force_N(), force.brake_N_s_per_m(), force.brake_Nm_s_per_rad()};
  }

 private:
  static FilterLimits WideOpen() {
    FilterLimits limits;
    limits.max_force_N = 150.0;
    limits.max_torque_Nm = 20.0;
    limits.max_force_rate_N_per_s = 1.0e6;
    limits.start_ramp_ns = 0;
    limits.restart_ramp_ns = 0;
    return limits;
  }
  static DeviceReading Held() {
    DeviceReading reading;
    reading.is_engaged = true;
    return reading;
  }
  SafetyFilter filter_;
  std::uint64_t sequence_ = 0;
};

ArmParameters FreeArm() {
  ArmParameters p;
  p.damping_N_s_per_m = 0.0;
  p.damping_Nm_s_per_rad = 0.0;
  p.hand = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  return p;
}

TEST(SimulatedArm, FreeArmUnderConstantForceFollowsNewton) {
  SimulatedArm arm(FreeArm());
  Motor motor;
  arm.Read(0);
  for (int i = 0; i < 50; ++i)
    arm.Write(i * core::kMillisecond_ns, motor.Force(i * core::kMillisecond_ns, {3.0, 0, 0}, {0, 0, 0.06}));
  const DeviceReading reading = arm.Read(50 * core::kMillisecond_ns);
  EXPECT_NEAR(reading.X_WD.translation.x, 0.5 * 2.0 * 0.05 * 0.05, 1e-12);
  EXPECT_NEAR(reading.V_WD.linear_m_per_s.x, 2.0 * 0.05, 1e-12);
  EXPECT_NEAR(core::RotationVector(reading.X_WD.rotation).z, 0.5 * 2.0 * 0.05 * 0.05, 1e-12);
  EXPECT_NEAR(reading.V_WD.angular_rad_per_s.z, 2.0 * 0.05, 1e-12);
}

TEST(SimulatedArm, DelaysCommandsByFractionsOfAStep) {
  ArmParameters p = FreeArm();
  p.command_delay_ns = 2'800'000;
  SimulatedArm arm(p);
  Motor motor;
  arm.Read(0);
  arm.Write(0, motor.Force(0, {1.5, 0, 0}));
  for (int i = 1; i <= 5; ++i)
    arm.Write(i * core::kMillisecond_ns, motor.Force(i * core::kMillisecond_ns, {1.5, 0, 0}));
  const double acting_s = 5e-3 - 2.8e-3;
  EXPECT_NEAR(arm.Read(5 * core::kMillisecond_ns).V_WD.linear_m_per_s.x, acting_s, 1e-12);
  EXPECT_NEAR(arm.Read(5 * core::kMillisecond_ns).X_WD.translation.x, 0.5 * acting_s * acting_s, 1e-12);
}

TEST(SimulatedArm, ItsOwnWatchdogDropsTheForceAfter60MsAndBrakes) {
  const ArmParameters p = FreeArm();
  SimulatedArm arm(p);
  Motor motor;
  arm.Read(0);
  arm.Write(0, motor.Force(0, {1.5, 0, 0}));
  EXPECT_NEAR(arm.Read(60 * core::kMillisecond_ns).V_WD.linear_m_per_s.x, 0.06, 1e-12);
  const double thrown_m = arm.Read(60 * core::kMillisecond_ns).X_WD.translation.x;
  EXPECT_NEAR(arm.Read(1000 * core::kMillisecond_ns).V_WD.linear_m_per_s.x, 0.0, 1e-12);
  // m v' = -B v from there on.
  EXPECT_NEAR(arm.Read(1000 * core::kMillisecond_ns).X_WD.translation.x - thrown_m,
              0.06 * p.mass_kg / p.brake_N_s_per_m, 1e-12);
  EXPECT_EQ(arm.Felt().F_Do_W.force_N.x, 0.0);
}

// The bridge's process hangs while the hand presses.
TEST(SimulatedArm, StaysNearTheContactWhenTheBridgeHangs) {
  SimulatedArm arm(ArmParameters{});
  Motor motor;
  HandTarget hand;
  hand.X_WT.translation.z = -0.01;
  hand.V_WT.linear_m_per_s.z = -0.05;
  arm.Read(0);
  arm.Write(0, motor.Force(0, {0, 0, 8.0}));  // holds the spring of 800 N/m
  arm.SetHand(hand);
  EXPECT_GT(arm.Read(1000 * core::kMillisecond_ns).X_WD.translation.z, -0.013) << "not 5 cm on, and not at once";
}

TEST(SimulatedArm, BallOnAPlaneSettlesAtTheClosedFormDepth) {
  // Hand spring K_h to a target t below the plane, plane K_w sampled at 1 kHz: K_h (t - x) = K_w x at rest.
  ArmParameters p;
  SimulatedArm arm(p);
  Motor motor;
  const double target_m = 0.01;
  const double K_w = 2500.0;
  HandTarget hand;
  hand.X_WT.translation.z = -target_m;
  arm.Read(0);
  arm.SetHand(hand);
  double force_N = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const DeviceReading reading = arm.Read(i * core::kMillisecond_ns);
    force_N = -K_w * std::min(0.0, reading.X_WD.translation.z);
    arm.Write(i * core::kMillisecond_ns, motor.Force(i * core::kMillisecond_ns, {0, 0, force_N}));
  }
  const double K_h = p.hand.stiffness_N_per_m;
  EXPECT_NEAR(-arm.Read(4000 * core::kMillisecond_ns).X_WD.translation.z, K_h * target_m / (K_h + K_w), 1e-9);
  EXPECT_NEAR(force_N, K_h * K_w / (K_h + K_w) * target_m, 1e-6);
  EXPECT_NEAR(arm.Felt().hand_F_Do_W.force_N.z, -force_N, 1e-6);
}

TEST(SimulatedArm, TheJointedArmComesToRestWhereThePointMassDoes) {
  for (const bool is_jointed : {false, true}) {
    ArmParameters p;
    p.is_jointed = is_jointed;
    p.X_WD_start.translation = {0.2, 0.1, -0.3};
    SimulatedArm arm(p);
    Motor motor;
    arm.Read(0);
    HandTarget hand;
    hand.X_WT = p.X_WD_start;
    hand.X_WT.translation.z -= 0.02;
    arm.SetHand(hand);
    for (int i = 0; i < 3000; ++i)
      arm.Write(i * core::kMillisecond_ns, motor.Force(i * core::kMillisecond_ns, {4.0, 0, 0}, {0, 0, 0.1}));
    const DeviceReading reading = arm.Read(3000 * core::kMillisecond_ns);
    const glm::dvec3 wanted = hand.X_WT.translation + glm::dvec3(4.0 / p.hand.stiffness_N_per_m, 0, 0);
    EXPECT_LT(glm::length(reading.X_WD.translation - wanted), 1e-7) << is_jointed;
    EXPECT_NEAR(core::RotationVector(reading.X_WD.rotation).z, 0.1 / p.hand.stiffness_Nm_per_rad, 1e-7) << is_jointed;
    EXPECT_NEAR(arm.Felt().hand_F_Do_W.force_N.x, -4.0, 1e-4) << is_jointed;
  }
}

// Whether the motion of a mass decays on a sampled wall with stiffness K = alpha m / T^2, damping B = beta m / T
// (backward difference) and a delay of `delay_ticks`.
bool IsStable(double alpha, double beta, int delay_ticks) {
  const double m = 1.5;
  const double T = 1e-3;
  ArmParameters p = FreeArm();
  p.mass_kg = m;
  p.command_delay_ns = delay_ticks * core::kMillisecond_ns;
  p.X_WD_start.translation.x = 1e-7;
  SimulatedArm arm(p);
  Motor motor;
  const double K = alpha * m / (T * T);
  const double B = beta * m / T;
  double previous = arm.Read(0).X_WD.translation.x;
  double early = 0.0;
  double late = 0.0;
  constexpr int kTicks = 12000;
  for (int i = 1; i < kTicks; ++i) {
    const double x = arm.Read(i * core::kMillisecond_ns).X_WD.translation.x;
    arm.Write(i * core::kMillisecond_ns,
              motor.Force(i * core::kMillisecond_ns, {-(K * x + B * (x - previous) / T), 0, 0}));
    previous = x;
    if (i > 500 && i < 1500) early = std::max(early, std::abs(x));
    if (i >= kTicks - 1000) late = std::max(late, std::abs(x));
    if (std::abs(x) > 1e-4) return false;
  }
  return late < early;
}

TEST(SimulatedArm, ReproducesTheExactStabilityBoundaryOfASampledDelayedWall) {
  for (const int d : {0, 1, 2, 3}) {
    const stability::Wall wall = stability::StiffestWall({1.0, 0.0, 1.0, static_cast<double>(d)});
    EXPECT_TRUE(IsStable(0.99 * wall.stiffness_N_per_m, wall.damping_N_s_per_m, d)) << d;
    EXPECT_FALSE(IsStable(1.01 * wall.stiffness_N_per_m, wall.damping_N_s_per_m, d)) << d;
  }
}

TEST(SimulatedArm, TracksAMovingTargetInFreeSpace) {
  SimulatedArm arm(ArmParameters{});
  Motor motor;
  arm.Read(0);
  HandTarget hand;
  double lag_m = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double t = i * 1e-3;
    hand.X_WT.translation.x = 0.1 * t;
    hand.V_WT.linear_m_per_s.x = 0.1;
    arm.SetHand(hand);
    const DeviceReading reading = arm.Read((i + 1) * core::kMillisecond_ns);
    lag_m = 0.1 * (t + 1e-3) - reading.X_WD.translation.x;
    arm.Write((i + 1) * core::kMillisecond_ns, motor.Force((i + 1) * core::kMillisecond_ns, {0, 0, 0}));
  }
  // At rest in the moving frame the spring carries only the device's own drag: b v / K_h.
  EXPECT_NEAR(lag_m, 5.0 * 0.1 / 800.0, 1e-6);
}

TEST(SimulatedArm, LimitsTheFingersForceAndTheJawsOpening) {
  ArmParameters p;
  SimulatedArm arm(p);
  Motor motor;
  arm.Read(0);
  HandTarget hand;
  hand.opening_m = 0.0;
  hand.grip_strength_N = 20.0;
  arm.SetHand(hand);
  const double width_m = 0.03;
  const double K = 8000.0;
  double grip_N = 0.0;
  for (int i = 1; i < 2000; ++i) {
    const DeviceReading reading = arm.Read(i * core::kMillisecond_ns);
    grip_N = K * std::max(0.0, width_m - reading.opening_m);
    arm.Write(i * core::kMillisecond_ns, motor.Force(i * core::kMillisecond_ns, {}, {}, grip_N));
  }
  EXPECT_NEAR(grip_N, 20.0, 1e-6);  // the spring of 30 mm would pull with 45 N
  hand.opening_m = 0.5;
  arm.SetHand(hand);
  for (int i = 2000; i < 4000; ++i) arm.Write(i * core::kMillisecond_ns, motor.Force(i * core::kMillisecond_ns, {}));
  EXPECT_EQ(arm.Read(4000 * core::kMillisecond_ns).opening_m, p.opening_max_m);
}

TEST(SimulatedArm, ReportsThatItIsSimulated) {
  for (const oos_device_plugin* plugin : {&SimulatedArmPlugin(), &SimulatedHugPlugin()}) {
    const oos_device_setting setting{};
    void* device = nullptr;
    ASSERT_EQ(plugin->open(&setting, &device), OOS_DEVICE_OK);
    oos_device_description description{};
    ASSERT_EQ(plugin->describe(device, &description), OOS_DEVICE_OK);
    EXPECT_NE(description.flags & OOS_DEVICE_IS_SIMULATED, 0U);
    EXPECT_NE(std::string(description.name).find("simulated"), std::string::npos);
    plugin->close(device);
  }
}

}  // namespace
}  // namespace device_bridge
