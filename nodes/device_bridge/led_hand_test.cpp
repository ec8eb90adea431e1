// A hand that HUG leads to the next goal of the procedure, because a person asked for it.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/glm.hpp>

#include "nodes/device_bridge/testing/toy_world.hpp"

namespace device_bridge {
namespace {

constexpr double kLeading_N = 12.0;  // of libs/hug/guidance.hpp
constexpr double kLeading_Nm = 1.0;
constexpr double kPath_m_per_s = 0.25;
constexpr double kPath_rad_per_s = 0.8;

Options ByAPerson() {
  Options options;
  options.is_person_steering = true;
  return options;
}

// A person with an arm of HUG, 0.26 m and 0.4 rad away from `thing.spot`, in force. What is asked for is sent as a
// viewer does, every 30 ms.
struct LedHand {
  core::Pose X_WGoal{{1, 0, 0, 0}, {0.0, 0.0, 0.02}};
  double most_N = 0.0, most_Nm = 0.0, fastest_m_per_s = 0.0, fastest_rad_per_s = 0.0, most_of_hand_N = 0.0;
  ToyWorld world;

  explicit LedHand(const std::string& control = "guidance", double max_force_N = 40.0)
      : world(
            "step a\nreach thing.spot\nwait until held thing\n", 1,
            [&](scene::Scenario& scenario) {
              scene::Device& device = scenario.devices[0];
              device.type = "hug";
              device.options.emplace_back("control", control);
              device.max_force_N = max_force_N;
              device.X_WD_start = {core::QuaternionFromRollPitchYaw({0.0, 0.0, 0.4}), {0.2, 0.1, 0.15}};
            },
            ByAPerson()) {
    world.hands.push_back({});
    world.after = [this](ToyWorld& w) {
      if (w.now_ns / 1'000'000 % 30 == 0) ++w.hands[0].header.sequence;
      const core::DeviceState& state = w.outputs.states[0];
      const FeltForce felt = w.bridge->device(0).Felt();
      most_N = std::max(most_N, glm::length(felt.F_Do_W.force_N));
      most_Nm = std::max(most_Nm, glm::length(felt.F_Do_W.torque_Nm));
      most_of_hand_N = std::max(most_of_hand_N, glm::length(felt.hand_F_Do_W.force_N));
      fastest_m_per_s = std::max(fastest_m_per_s, glm::length(state.V_WD.linear_m_per_s));
      fastest_rad_per_s = std::max(fastest_rad_per_s, glm::length(state.V_WD.angular_rad_per_s));
    };
    world.Run(3.5);  // HUG's second of good link and its start ramp
    most_N = most_Nm = most_of_hand_N = fastest_m_per_s = fastest_rad_per_s = 0.0;
  }
  void Ask(bool wants = true) { world.hands[0].wants_guidance = wants; }
  [[nodiscard]] double away_m() const { return glm::distance(world.X_WD().translation, X_WGoal.translation); }
  [[nodiscard]] double turned_away_rad() const {
    return glm::length(core::RotationVector(world.X_WD().rotation * glm::conjugate(X_WGoal.rotation)));
  }
};

TEST(LedHand, ArrivesWithinTwoMillimetresBelowTheLimitsOfForceAndSpeed) {
  LedHand led;
  EXPECT_GT(led.away_m(), 0.25);
  led.Ask();
  led.world.Run(4.0);
  EXPECT_LT(led.away_m(), 0.002);
  EXPECT_LT(led.turned_away_rad(), 0.02);
  EXPECT_GT(led.most_N, 0.5);
  EXPECT_LE(led.most_N, kLeading_N + 1e-9);
  EXPECT_LE(led.most_Nm, kLeading_Nm + 1e-9);
  EXPECT_LT(led.fastest_m_per_s, 1.05 * kPath_m_per_s);
  EXPECT_LT(led.fastest_rad_per_s, 1.05 * kPath_rad_per_s);
}

TEST(LedHand, StaysWhereItIsUnlessItIsAskedForAndWhereHugDoesNotLead) {
  LedHand not_asked;
  not_asked.world.Run(2.0);
  EXPECT_GT(not_asked.away_m(), 0.25);
  LedHand asked;
  asked.Ask();
  asked.world.Run(0.5);
  asked.Ask(false);
  asked.world.Run(0.3);
  const double away_m = asked.away_m();
  asked.world.Run(2.0);
  EXPECT_GT(away_m, 0.05);
  EXPECT_NEAR(asked.away_m(), away_m, 0.002) << "who asks no longer is let go";
}

// The limit of device and scenario holds for command and guidance together.
TEST(LedHand, NeverGetsMoreThanTheFiltersLimit) {
  LedHand led("guidance", 6.0);
  led.world.contact = [](const core::DeviceState& /*state*/) { return core::Wrench{{0.0, 0.0, -5.5}, {}}; };
  led.world.hands[0].is_held = true;
  led.Ask();
  led.world.Run(0.5);
  led.world.hands[0].moved_W_m = {0.05, 0.05, 0.0};  // away from the path
  led.world.Run(1.0);
  EXPECT_GT(led.most_N, 5.9);
  EXPECT_LE(led.most_N, 6.0 + 1e-9);
}

// A person who moves the pointer away at 0.2 m/s is stronger: the hand is 50 mm off the straight way, no
// force is above its limit, and the path waits. Then it is led on.
TEST(LedHand, LeavesThePathWhenThePersonPushesAndComesBackWhenItDoesNot) {
  LedHand led;
  const glm::dvec3 begin_W = led.world.X_WD().translation;
  const glm::dvec3 way_W = glm::normalize(led.X_WGoal.translation - begin_W);
  const glm::dvec3 aside_W = glm::normalize(glm::cross(way_W, glm::dvec3(0, 0, 1)));
  const auto off_m = [&] { return glm::dot(led.world.X_WD().translation - begin_W, aside_W); };
  led.Ask();
  led.world.Run(0.7);
  EXPECT_LT(std::abs(off_m()), 0.01);
  core::HandInput& input = led.world.hands[0];
  input.is_held = true;
  led.world.Run(0.06);
  for (int i = 0; i < 10; ++i) {
    input.moved_W_m += 0.006 * aside_W;
    led.world.Run(0.03);
  }
  EXPECT_GT(off_m(), 0.05);
  EXPECT_GT(led.away_m(), 0.05) << "it waits";
  EXPECT_LE(led.most_N, kLeading_N + 1e-9);
  input.is_held = false;
  led.world.Run(5.0);
  EXPECT_LT(led.away_m(), 0.002);
  EXPECT_LE(led.most_N, kLeading_N + 1e-9);
}

TEST(LedHand, IsNotLedToAGoalThatIsNowhere) {
  LedHand led;
  led.Ask();
  led.world.Run(0.3);
  led.world.physics.bodies[0].X_WO.translation.x = std::nan("");
  led.world.Run(0.5);
  EXPECT_LT(led.fastest_m_per_s, 1.05 * kPath_m_per_s);
  EXPECT_TRUE(std::isfinite(led.most_N + led.away_m()));
  EXPECT_EQ(led.world.outputs.filter_status[0] & kNotFinite, 0U);
}

// A plug-in with a thread of its own, without it here, so that it lives in virtual time: the example. It moves by
// itself, so nobody holds it back. Its base is turned by a calibration.
struct LedByPlugIn {
  double most_N = 0.0;
  core::Pose X_WGoal{{1, 0, 0, 0}, {0.0, 0.0, 0.02}};
  ToyWorld world;

  LedByPlugIn()
      : world(
            "step a\nreach thing.spot\nwait until held thing\n", 1,
            [](scene::Scenario& scenario) {
              scene::Device& device = scenario.devices[0];
              device.type = "plugin";
              device.address = VR_OOS_BINARY_DIR "/test_plugins/leading_device.so";
            },
            Threadless()) {
    world.hands.push_back({});
    world.after = [this](ToyWorld& w) {
      if (w.now_ns / 1'000'000 % 30 == 0) ++w.hands[0].header.sequence;
      most_N = std::max(most_N, glm::length(w.bridge->device(0).Felt().F_Do_W.force_N));
    };
    world.Run(2.0);
  }
  static Options Threadless() {
    Options options = ByAPerson();
    options.threads.emplace();
    options.threads->has_thread = false;
    options.threads->find_calibration = [](const std::string&, const std::string&) {
      return DeviceCalibration{{core::QuaternionFromRollPitchYaw({0.3, -0.2, 1.0}), {0.15, 0.1, 0.1}}, 0.001};
    };
    return options;
  }
  [[nodiscard]] double away_m() const { return glm::distance(world.X_WD().translation, X_WGoal.translation); }
};

TEST(LedHand, IsLedByAPlugInWithAThreadOfItsOwn) {
  LedByPlugIn led;
  ASSERT_TRUE(led.world.bridge);
  const double begin_m = led.away_m();
  EXPECT_GT(begin_m, 0.15);
  EXPECT_EQ(led.most_N, 0.0) << "nobody has asked";
  led.world.hands[0].wants_guidance = true;
  led.world.Run(3.0);
  EXPECT_LT(led.away_m(), 0.002);
  EXPECT_GT(led.most_N, 0.5);
  EXPECT_LE(led.most_N, 4.0 + 1e-9) << "of the example";
  led.world.hands[0].wants_guidance = false;
  led.world.Run(0.1);
  EXPECT_EQ(glm::length(led.world.bridge->device(0).Felt().F_Do_W.force_N), 0.0);
}

// With another control, the scripted operator shows the way, by the hand's own spring.
TEST(LedHand, IsTheScriptedOperatorsWhereTheDeviceDoesNotLead) {
  LedHand led("admittance");
  led.Ask();
  led.world.Run(6.0);
  EXPECT_LT(led.away_m(), 0.006);
  EXPECT_GT(led.most_of_hand_N, 1.0);
  EXPECT_LT(led.most_N, 0.1);
}

}  // namespace
}  // namespace device_bridge
