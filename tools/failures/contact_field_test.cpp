// The local contact field: the steps of HapticNode and DeviceBridge in turn, with the command some ticks late.

#include "nodes/device_bridge/contact_field.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>

#include "tools/failures/loop.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kTick_s = 1e-3;

// A hand and device of 1.5 kg at a plate; the command is 3 ms late.
SceneKit Wall(double K_N_per_m, bool has_field) {
  SceneKit kit = BallOverPlate(Variants().back(), 1e-5);
  kit.scenario.coupling.stiffness_N_per_m = K_N_per_m;
  kit.scenario.coupling.has_field = has_field;
  kit.device().hand_stiffness_N_per_m = 1000.0;
  kit.device().hand_damping_N_s_per_m = 30.0;
  return kit;
}

LoopOptions Press(double by_m, const std::string& after = "wait 600") {
  LoopOptions options;
  options.command_delay_ticks = 3;
  options.script = "wait 1.2\npush 0 0 -1 by " + std::to_string(by_m) + " speed 0.05\n" + after;
  return options;
}

double Norm(const core::Wrench& F) {
  return glm::length(F.force_N);
}

TEST(FieldInTheBridge, CountsNothingTwice) {
  for (const double cap_N : {1000.0, 5.0}) {
    SceneKit kit = Wall(20000.0, true);
    kit.scenario.force_cap_N = cap_N;
    Loop loop(kit.scenario, Press(0.02, "push 1 0 0 by 0.02 speed 0.1\nwait 600"));
    device_bridge::ContactField field;
    int num_in_force = 0;
    for (int i = 0; i < 2500; ++i) {
      loop.Tick();
      const core::DeviceCommand& command = loop.haptic().commands[0];
      ASSERT_TRUE(command.has_field);
      field.Forget();
      field.Take(command, command.X_WD, command.header.direct.origin_ns);
      const core::Wrench change = field.Change(command.X_WD, command.header.direct.origin_ns);
      ASSERT_EQ(change.force_N, glm::dvec3(0.0)) << i;
      ASSERT_EQ(change.torque_Nm, glm::dvec3(0.0)) << i;
      if (Norm(command.F_Do_W) > 1.0) ++num_in_force;
    }
    EXPECT_GT(num_in_force, 500);
  }
}

TEST(FieldInTheBridge, RendersAWallWithoutTheDelayOfItsCommand) {
  constexpr double kK = 5000.0;
  Loop loop(Wall(kK, true).scenario, Press(0.01));
  const core::Pose start = BallOverPlate(Variants().back(), 1e-5).scenario.devices[0].X_WD_start;
  double most_N = 0.0;
  double worst_N = 0.0;
  for (int i = 0; i < 3000; ++i) {
    loop.Tick();
    const double depth_m = start.translation.z - 1e-5 - loop.device().X_WD.translation.z;
    const double exact_N = kK * std::max(0.0, depth_m);
    most_N = std::max(most_N, exact_N);
    worst_N = std::max(worst_N, std::abs(loop.exerted().force_N.z - exact_N));
  }
  EXPECT_GT(most_N, 5.0);
  EXPECT_LT(worst_N, 0.02 * most_N);
}

// The force right before and right after a command arrives, 3 ms late, at the same place of the device.
struct Steps {
  double largest_N = 0.0;          // with the field
  double largest_without_N = 0.0;  // of the commands' forces by themselves
};
Steps StepsOfTheForce(const SceneKit& kit, const LoopOptions& options, double from_s, double until_s) {
  Loop loop(kit.scenario, options);
  std::deque<core::DeviceCommand> on_their_way;
  core::DeviceCommand last;
  device_bridge::ContactField field;
  Steps steps;
  while (loop.now_s() < until_s) {
    loop.Tick();
    on_their_way.push_back(loop.haptic().commands[0]);
    if (on_their_way.size() <= 3) continue;
    const core::DeviceCommand command = on_their_way.front();
    on_their_way.pop_front();
    const core::Pose& X_WD = loop.device().X_WD;
    const core::Wrench before = last.F_Do_W + field.Change(X_WD, loop.device().sample_ns);
    field.Take(command, X_WD, loop.device().sample_ns);
    const core::Wrench after = command.F_Do_W + field.Change(X_WD, loop.device().sample_ns);
    if (loop.now_s() >= from_s) {
      steps.largest_N = std::max(steps.largest_N, Norm(after + -before));
      steps.largest_without_N = std::max(steps.largest_without_N, Norm(command.F_Do_W + -last.F_Do_W));
    }
    last = command;
  }
  return steps;
}
TEST(FieldInTheBridge, DoesNotStepTheForceWhenANewOneArrives) {
  const Steps steps = StepsOfTheForce(
      Wall(5000.0, true), Press(0.012, "push 1 0 0 by 0.05 speed 0.2\npush 0 0 1 by 0.03 speed 0.3\nwait 9"), 0.1, 5.0);
  EXPECT_LT(steps.largest_N, 1e-9);
  EXPECT_GT(steps.largest_without_N, 0.1);
}

// Pressed with 4 N, which is 0.1 mm. Whether the motion decays while the passivity controller has nothing to do.
bool IsStable(double K_N_per_m, bool has_field) {
  Loop loop(Wall(K_N_per_m, has_field).scenario, Press(0.004));
  loop.Run(3.0);
  double fastest_m_per_s = 0.0;
  for (int i = 0; i < 1000; ++i) {
    loop.Tick();
    fastest_m_per_s = std::max(fastest_m_per_s, std::abs(loop.device().V_WD.linear_m_per_s.z));
  }
  const double share = loop.bridge().figures(0).share_made_passive();
  return fastest_m_per_s < 1e-3 && share < 0.01 && loop.energy().least_J() >= -1e-3;
}
TEST(FieldInTheBridge, HoldsAWallFourTimesStifferThreeMillisecondsLate) {
  EXPECT_TRUE(IsStable(7000.0, false)) << "the exact boundary of the late wrench is 10.1 kN/m";
  EXPECT_FALSE(IsStable(11000.0, false));
  EXPECT_TRUE(IsStable(10000.0, true));
  EXPECT_TRUE(IsStable(44000.0, true));
}

// haptic_node lowers its stiffness to what the bridge allows: with the field, for the device's own delay.
TEST(FieldInTheBridge, AllowsTheStiffnessOfTheDevicesOwnLoop) {
  for (const bool has_field : {true, false}) {
    SceneKit kit = Wall(5000.0, has_field);
    kit.device().command_delay_s = 0.5e-3;
    Loop loop(kit.scenario, Press(0.004));
    loop.Run(2.0);
    const device_bridge::RoleFigures figures = loop.bridge().figures(0);
    EXPECT_GT(figures.loop_delay_s, 3.4e-3);
    EXPECT_NEAR(figures.allowed.delay_s, has_field ? 0.5e-3 : figures.loop_delay_s, 1e-9);
  }
}

// The plane of a body at velocity v under a device that moves along with it: nothing changes.
TEST(FieldInTheBridge, GoesOnWithABodyThatMoves) {
  core::DeviceCommand command;
  command.header.direct.id = 1;
  command.header.direct.origin_ns = 1'000'000'000;
  command.has_field = true;
  command.stiffness_N_per_m = 10000.0;
  command.stiffness_Nm_per_rad = 30.0;
  command.force_cap_N = 40.0;
  command.gain = 1.0;
  command.X_WC.translation.z = 0.02;
  command.X_WD.translation.z = 0.019;
  command.F_Do_W.force_N = {0, 0, 10};
  core::FieldContact contact;
  contact.p_C_W = {0, 0, -0.02f};
  contact.n_W = {0, 0, 1};
  contact.v_W = {0.02f, 0, 0.1f};
  contact.friction = 0.3f;
  contact.normal_N = 10.0f;
  command.contacts.push_back(contact);
  device_bridge::ContactField field;
  field.Take(command, command.X_WD, 1'000'000'000);
  core::Pose X_WD = command.X_WD;
  for (int i = 1; i <= 10; ++i) {
    X_WD.translation += kTick_s * glm::dvec3(contact.v_W);
    EXPECT_LT(Norm(field.Change(X_WD, 1'000'000'000 + i * 1'000'000)), 1e-4) << i;
  }
  EXPECT_LT(Norm(field.Change(X_WD, 1'020'000'000)), 1e-4) << "after its time the body stands still";
  EXPECT_GT(field.Change(command.X_WD, 1'010'000'000).force_N.z, 9.0) << "a device that stays is pushed";
}

// The reaction of a grasp is not the coupling's: it acts at once, and only what the contacts say is led over.
TEST(FieldInTheBridge, AGraspsReactionActsAtOnce) {
  core::DeviceCommand command;
  command.has_field = true;
  command.stiffness_N_per_m = 10000.0;
  command.stiffness_Nm_per_rad = 30.0;
  command.force_cap_N = 40.0;
  command.gain = 1.0;
  device_bridge::ContactField field;
  field.Take(command, {}, 1'000'000);
  command.F_Do_W.force_N = command.F_rest_Do_W.force_N = {3, 0, 0};
  field.Take(command, {}, 2'000'000);
  EXPECT_LT(Norm(field.Change({}, 2'000'000)), 1e-12);
  command.F_Do_W.force_N = {5, 0, 0};  // 2 N of a contact that nothing announced
  field.Take(command, {}, 3'000'000);
  EXPECT_NEAR(field.Change({}, 3'000'000).force_N.x, -2.0, 1e-12);
  EXPECT_NEAR(field.Change({}, 4'000'000).force_N.x, -2.0 * std::exp(-1.0), 1e-12);
}

struct Lost {
  double pressed_N = 0.0;
  double fastest_m_per_s = 0.0;
  double force_after_60_ms_N = 0.0;
};
// The link dies at cut_s; what happens in the 0.3 s after.
Lost LoseTheLink(Loop* loop, double cut_s) {
  Lost lost;
  while (loop->now_s() < cut_s) loop->Tick();
  lost.pressed_N = Norm(loop->exerted());
  loop->CutLink();
  for (int i = 0; i < 300; ++i) {
    loop->Tick();
    lost.fastest_m_per_s = std::max(lost.fastest_m_per_s, glm::length(loop->device().V_WD.linear_m_per_s));
    if (i >= 60) lost.force_after_60_ms_N = std::max(lost.force_after_60_ms_N, Norm(loop->exerted()));
  }
  return lost;
}

TEST(FieldInTheBridge, FadesWithItsCommandAndTheHandStaysSlow) {
  for (const double K_N_per_m : {2500.0, 40000.0}) {
    Loop loop(Wall(K_N_per_m, true).scenario, Press(0.025 + 24.0 / K_N_per_m));
    const Lost lost = LoseTheLink(&loop, 4.0);
    EXPECT_GT(lost.pressed_N, 20.0);
    EXPECT_EQ(lost.force_after_60_ms_N, 0.0);
    EXPECT_LE(lost.fastest_m_per_s, 0.30) << "into the wall, " << K_N_per_m << " N/m";
  }
}

TEST(FieldInTheBridge, DoesNotFlingADeviceThatIsLetGoWhenTheLinkDies) {
  for (const double K_N_per_m : {2500.0, 40000.0}) {
    Loop loop(Wall(K_N_per_m, true).scenario, Press(0.025 + 24.0 / K_N_per_m));
    loop.Run(4.0);
    loop.OpenHand();
    const Lost lost = LoseTheLink(&loop, 4.0);
    EXPECT_GT(lost.pressed_N, 20.0);
    EXPECT_LE(lost.fastest_m_per_s, 0.30) << K_N_per_m << " N/m";
  }
}

// A ball as hand, 5 mm over a free box of 2 kg. There is no gravity.
SceneKit BallOverFreeBox(scene::ContactInput input, bool is_on_plate) {
  SceneKit kit(Variants().back());
  kit.scenario.contact_input = input;
  const auto box = kit.AddBody(vps::MakeBox(glm::dvec3(0.1)), {{1, 0, 0, 0}, {0, 0, 0.05}}, 2.0, kVoxel_m, 4096);
  const auto ball =
      kit.AddHand(vps::MakeSphere(kBall_m, 64), {{1, 0, 0, 0}, {0, 0, 0.1 + kBall_m + 5e-3}}, kToolPoints);
  kit.AddPair(ball, box);
  if (is_on_plate) {
    const auto plate =
        kit.AddFixed(vps::MakeBox({0.2, 0.2, kPlate_m}), {{1, 0, 0, 0}, {0, 0, -0.5 * kPlate_m}}, kVoxel_m);
    kit.AddPair(box, plate);
  }
  return kit;
}

TEST(FieldInTheBridge, ClosesTheBooksWithinOnePercent) {
  for (const scene::ContactInput input : {scene::ContactInput::kPlanes, scene::ContactInput::kWrench}) {
    LoopOptions options;
    options.command_delay_ticks = 1;
    options.script = "wait 1.2\npush 0 0 -1 by 0.1 speed 0.1\nwait 600";
    Loop loop(BallOverFreeBox(input, false).scenario, options);
    loop.Run(4.0);
    const double momentum_Ns = 2.0 * loop.body(0).V_WO.linear_m_per_s.z;
    const double rendered_Ns = loop.device().J_contact_Wo_W.force_N.z;
    const double given_Ns = loop.reaction().J_contact_Wo_W.force_N.z;
    EXPECT_LT(momentum_Ns, -0.1);
    EXPECT_NEAR(-given_Ns, momentum_Ns, 1e-9);
    EXPECT_NEAR(-rendered_Ns, momentum_Ns, -0.01 * momentum_Ns) << static_cast<int>(input);
  }
}

// Pressed, pushed aside and let go over and over, on a plate. With planes physics makes damping and friction by laws of
// its own.
TEST(FieldInTheBridge, ClosesTheBooksOfABoxThatIsPressedAtAPlate) {
  for (const scene::ContactInput input : {scene::ContactInput::kPlanes, scene::ContactInput::kWrench}) {
    LoopOptions options;
    options.command_delay_ticks = 1;
    options.tremor_m = 2e-4;
    options.script = "wait 1.2\n";
    for (int i = 0; i < 5; ++i) {
      options.script +=
          "push 0 0 -1 by 0.012 speed 0.1\npush 1 0 0 by 0.004 speed 0.05\npush 0 0 1 by 0.012 speed 0.1\n"
          "push -1 0 0 by 0.004 speed 0.05\n";
    }
    Loop loop(BallOverFreeBox(input, true).scenario, options);
    loop.Run(8.0);
    const core::Wrench& given = loop.reaction().J_contact_Wo_W;
    const core::Wrench owed = loop.device().J_contact_Wo_W + -given;
    const double given_Ns = glm::length(given.force_N);
    EXPECT_GT(given.force_N.z, 5.0);
    EXPECT_LT(glm::length(owed.force_N), 0.01 * given_Ns);
    EXPECT_LT(glm::length(owed.torque_Nm), 0.01 * 0.1 * given_Ns) << "at 0.1 m from W's origin";
  }
}

}  // namespace
}  // namespace failures
