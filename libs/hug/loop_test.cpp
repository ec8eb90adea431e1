#include <gtest/gtest.h>

#include <cmath>

#include "hug/machine.hpp"
#include "hug/testing/arm_rig.hpp"
#include "stability/sampled_axis.hpp"

namespace hug {
namespace {

constexpr Side kSides[] = {Side::kRight, Side::kLeft};
constexpr double kPeriod_s = 1e-3;

// Two arms in force whose hands hold them without stiffness, each before a wall across z. Each wall is computed once
// per millisecond from the arm's pose, with the velocity as a difference, and acts a millisecond later.
struct TwoWalls {
  Machine machine{MachineFigures{}};
  stability::Wall walls[2];
  double z_m[2] = {}, before_m[2] = {}, largest_N = 0.0;
  core::Wrench late[2];
  std::int64_t ms = 0;

  TwoWalls() {
    for (int i = 0; i < 2; ++i) {
      ArmFigures figures;
      figures.hand = NoHand();
      figures.mount.mass_kg = 0.0;
      figures.sensors.force_noise_N = figures.sensors.wrist_torque_noise_Nm = figures.sensors.torque_noise_Nm = 0.0;
      figures.sensors.motor_step_rad = 1e-9;
      const core::Pose X_WD{{1, 0, 0, 0}, {0.6, i == 0 ? -0.3 : 0.3, 0.2}};
      EXPECT_TRUE(machine.Open(kSides[i], figures, X_WD));
      Hand hand;
      hand.X_WT = X_WD;
      hand.holds_dead_man = true;
      machine.arm(kSides[i]).SetHand(hand);
    }
    Run(2300);
    for (int i = 0; i < 2; ++i) {
      EXPECT_EQ(machine.arm(kSides[i]).safety().state(), SafetyState::kForce);
      z_m[i] = before_m[i] = machine.arm(kSides[i]).X_WD().translation.z;
    }
  }
  // Free arm: 30 % of what J M^-1 J^T says in the posture that it has.
  [[nodiscard]] stability::SampledAxis Axis(int i) {
    ArmDynamics arm = machine.arm(kSides[i]).measured();
    return {0.3 / arm.InverseApparentInertia()[5][5], 0.0, kPeriod_s, kPeriod_s};
  }
  void Run(int milliseconds) {
    for (int end = milliseconds; end > 0; --end) {
      machine.AdvanceTo(ms++ * 1'000'000);
      for (int i = 0; i < 2; ++i) {
        Arm& arm = machine.arm(kSides[i]);
        arm.Send({late[i]});
        const double now_m = arm.X_WD().translation.z;
        late[i].force_N.z = -walls[i].stiffness_N_per_m * (now_m - z_m[i]) -
                            walls[i].damping_N_s_per_m * (now_m - before_m[i]) / kPeriod_s;
        before_m[i] = now_m;
        largest_N = std::max(largest_N, std::abs(late[i].force_N.z));
      }
    }
  }
  double LargestOver(int milliseconds) {
    largest_N = 0.0;
    Run(milliseconds);
    return largest_N;
  }
};

// The boundary of stability is that of a mass [Hulin et al.], exact for each arm at rest. A push of 0.2 N for a
// millisecond begins the swing, at most some newtons.
TEST(TwoArms, SwingDecaysJustInsideTheExactBoundaryAndGrowsJustOutside) {
  for (const double share : {0.95, 1.05}) {
    for (const double damping_share : {0.2, 0.5}) {
      TwoWalls loop;
      for (int i = 0; i < 2; ++i) {
        const stability::SampledAxis axis = loop.Axis(i);
        EXPECT_GT(axis.mass_kg, 0.3);
        EXPECT_LT(axis.mass_kg, 3.0);
        const double B = damping_share * 0.82843 * axis.mass_kg / kPeriod_s;
        loop.walls[i] = {share * stability::MaxStiffness(axis, B), B};
        core::Wrench push;
        push.force_N.z = 0.2;
        loop.machine.arm(kSides[i]).PushBy(push);
      }
      loop.Run(1);
      for (const Side side : kSides) loop.machine.arm(side).PushBy({});
      loop.Run(20);
      const double early_N = loop.LargestOver(20);
      loop.Run(60);
      const double later_N = loop.LargestOver(20);
      EXPECT_EQ(later_N > early_N, share > 1.0)
          << share << " " << damping_share << ": " << early_N << " then " << later_N;
    }
  }
}

}  // namespace
}  // namespace hug
