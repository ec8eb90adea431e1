#include "hug/safety_states.hpp"

#include <gtest/gtest.h>

#include <string>

#include "hug/testing/arm_rig.hpp"

namespace hug {
namespace {

SafetyInputs Good(double dt_s) {
  SafetyInputs in;
  in.dt_s = dt_s;
  in.is_dead_man_held = in.is_clutch_closed = true;
  in.command_age_s = 0.001;
  return in;
}

void Let(SafetyStates* states, const SafetyInputs& in, double duration_s) {
  for (double t = 0.0; t < duration_s - 1e-9; t += in.dt_s) states->Step({}, in);
}

SafetyStates InForce() {
  SafetyStates states;
  Let(&states, Good(0.001), 2.2);
  EXPECT_EQ(states.state(), SafetyState::kForce);
  return states;
}

TEST(SafetyStates, LateCommandsDegradeThenBrakeAndForceComesBackByItself) {
  SafetyStates states = InForce();
  SafetyInputs late = Good(0.001);
  late.command_age_s = 0.02;
  Let(&states, late, 0.01);
  EXPECT_EQ(states.state(), SafetyState::kDegraded);
  EXPECT_EQ(states.share(), 1.0);
  Let(&states, Good(0.001), 0.002);
  EXPECT_EQ(states.state(), SafetyState::kForce);
  late.command_age_s = 0.061;
  late.hand_speed_m_per_s = 0.3;
  Let(&states, late, 0.002);
  EXPECT_EQ(states.state(), SafetyState::kBrake);
  EXPECT_EQ(states.share(), 0.0);
  Let(&states, Good(0.001), 3.0);
  EXPECT_EQ(states.state(), SafetyState::kForce);
}

TEST(SafetyStates, TheDeadManBrakesAtOnceAndEngagesAnew) {
  SafetyStates states = InForce();
  SafetyInputs open = Good(0.001);
  open.is_dead_man_held = false;
  Let(&states, open, 0.001);
  EXPECT_EQ(states.state(), SafetyState::kBrake);
  Let(&states, open, 0.1);
  EXPECT_EQ(states.state(), SafetyState::kReady);
  Let(&states, Good(0.001), 0.002);
  EXPECT_EQ(states.state(), SafetyState::kEngaging);
  EXPECT_LT(states.share(), 0.01);
}

TEST(SafetyStates, AFaultStaysUntilTheDeadManWasLetGoAndKeepsItsFirstCause) {
  SafetyStates states = InForce();
  SafetyInputs bad = Good(0.001);
  bad.fault = FaultCause::kClutch;
  Let(&states, bad, 0.01);
  bad.fault = FaultCause::kHeat;
  Let(&states, bad, 0.01);
  EXPECT_EQ(states.state(), SafetyState::kFault);
  EXPECT_EQ(states.first_cause(), FaultCause::kClutch);
  Let(&states, Good(0.001), 5.0);
  EXPECT_EQ(states.state(), SafetyState::kFault) << "still held";
  SafetyInputs open = Good(0.001);
  open.is_dead_man_held = false;
  Let(&states, open, 0.6);
  EXPECT_NE(states.state(), SafetyState::kFault);
  Let(&states, Good(0.001), 2.5);
  EXPECT_EQ(states.state(), SafetyState::kForce);
  EXPECT_EQ(states.first_cause(), FaultCause::kClutch) << "of the latest loss of force";
}

TEST(SafetyStates, AHandThatIsTooFastIsAFault) {
  SafetyStates states = InForce();
  SafetyInputs fast = Good(0.001);
  fast.hand_speed_m_per_s = 1.6;
  Let(&states, fast, 0.001);
  EXPECT_EQ(states.state(), SafetyState::kFault);
  EXPECT_EQ(states.first_cause(), FaultCause::kSpeed);
}

struct Case {
  const char* fault;
  SafetyState state;
  FaultCause cause;
};

// Each fault that can be switched on, at an arm that a hand moves to and fro under a force of 10 N.
TEST(Faults, EachOneIsNoticedByNameAndTheForceIsGone) {
  for (const Case& c : {Case{"stuck_sensor joint 1 at 2.5", SafetyState::kFault, FaultCause::kPositionSensors},
                        {"encoder_jump 0.05 joint 4 at 2.5", SafetyState::kFault, FaultCause::kPositionSensors},
                        {"torque_bias 5 joint 2 at 2.5", SafetyState::kFault, FaultCause::kTorqueSensors},
                        {"force_bias 60 at 2.5", SafetyState::kFault, FaultCause::kForceSensor},
                        {"force_bias 20 at 2.5", SafetyState::kFault, FaultCause::kForceSensor},
                        {"clutch_trip at 2.5", SafetyState::kFault, FaultCause::kClutch},
                        {"overheat at 2.5", SafetyState::kFault, FaultCause::kHeat},
                        {"unplug at 2.5", SafetyState::kOff, FaultCause::kNone},
                        {"loss 1 at 2.5", SafetyState::kIdle, FaultCause::kNone},
                        {"dead_man_glitch at 2.5", SafetyState::kReady, FaultCause::kNone}}) {
    ArmFigures figures;
    const auto faults = ParseFaults(c.fault);
    ASSERT_TRUE(faults) << faults.error().detail;
    figures.faults = *faults;
    ArmRig rig(figures);
    rig.command.F_Do_W.force_N = {0.0, 10.0, 0.0};
    double fastest = 0.0;
    const double y_m = rig.hand.X_WT.translation.y;
    rig.at_each_step = [&] {
      if (rig.arm.time_s() > 2.2) rig.hand.X_WT.translation.y = y_m + 0.05 * std::sin(4.0 * (rig.arm.time_s() - 2.2));
      fastest = std::max(fastest, glm::length(rig.arm.V_WD().linear_m_per_s));
    };
    rig.Run(2.45);
    EXPECT_EQ(rig.arm.safety().state(), SafetyState::kForce) << c.fault;
    EXPECT_EQ(rig.arm.safety().first_cause(), FaultCause::kNone) << c.fault;
    rig.Run(0.85);
    EXPECT_EQ(rig.arm.safety().state(), c.state) << c.fault << ": " << NameOf(rig.arm.safety().state());
    EXPECT_EQ(rig.arm.safety().first_cause(), c.cause) << c.fault << ": " << NameOf(rig.arm.safety().first_cause());
    EXPECT_EQ(rig.arm.motors_F_Do_W().force_N, glm::dvec3(0.0)) << c.fault;
    // By the true speeds: a broken sensor may say anything.
    for (const double speed : rig.arm.truth().speed) EXPECT_LT(std::abs(speed), 1e-3) << c.fault;
    if (c.cause != FaultCause::kPositionSensors) {
      EXPECT_LT(fastest, 0.6) << c.fault;
    }
  }
}

TEST(Faults, DelayJitterAndSomeLossAreBorne) {
  ArmFigures figures;
  figures.faults = *ParseFaults("delay 0.002 at 2.3; jitter 0.003 at 2.3; loss 0.2 at 2.3");
  ArmRig rig(figures);
  rig.Run(5.0);
  EXPECT_EQ(rig.arm.safety().state(), SafetyState::kForce);
  EXPECT_EQ(rig.arm.safety().first_cause(), FaultCause::kNone);
}

TEST(Faults, AWrongTextSaysWhatIsWrongAndWhatToWrite) {
  const auto text = [](const char* fault) { return ParseFaults(fault).error().detail; };
  EXPECT_NE(text("stuck_senor at 2").find("stuck_sensor"), std::string::npos) << text("stuck_senor at 2");
  EXPECT_NE(text("loss").find("amount"), std::string::npos);
  EXPECT_NE(text("overheat joint 9").find("joint"), std::string::npos);
  EXPECT_NE(text("overheat at soon").find("number"), std::string::npos);
  EXPECT_TRUE(ParseFaults(""));
}

}  // namespace
}  // namespace hug
