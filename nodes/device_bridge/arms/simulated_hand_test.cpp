#include "nodes/device_bridge/arms/simulated_hand.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "nodes/device_bridge/devices/plugin_table.hpp"
#include "nodes/device_bridge/devices/plugin_values.hpp"
#include "tracking/finger_angles.hpp"

namespace device_bridge {
namespace {

constexpr std::int64_t kHandTick_ns = 1'000'000;

// A device of the type, with something between its jaws that gives 8 kN/m.
class SimulatedHandTest : public ::testing::Test {
 protected:
  void TearDown() override {
    if (device_ != nullptr) table_.functions->close(device_);
  }
  int Open(const std::string& grip) {
    scene::Device figures;
    figures.role = "right";
    figures.type = "simulated_hand";
    figures.opening_max_m = 0.08;
    figures.opening_start_m = 0.06;
    figures.X_WD_start.translation = {0.1, 0.2, 0.3};
    if (!grip.empty()) figures.options = {{"grip", grip}};
    table_ = *FindPlugin("simulated_hand", "");
    const DeviceSetting setting(figures);
    const oos_device_setting view = setting.View(why_, sizeof why_);
    hand_.X_BT[0] = 1.0;
    hand_.holds_dead_man = 1;
    hand_.opening_m = 0.06;
    return table_.functions->open(&view, &device_);
  }
  void Step(int ticks, double width_m) {
    for (int i = 0; i < ticks; ++i) {
      now_ns_ += kHandTick_ns;
      pressed_N_ = 8000.0 * std::max(0.0, width_m - state_.opening_m);
      oos_device_command command{};
      command.grip_force_N = pressed_N_;
      command.F_Do_B[2] = 20.0;  // it has no motor that could follow
      table_.functions->step(device_, now_ns_, &command, nullptr, &state_);
      table_.functions->step(device_, now_ns_, nullptr, &hand_, &state_);
    }
  }

  PluginTable table_;
  void* device_ = nullptr;
  char why_[200] = "";
  oos_device_hand hand_{};
  oos_device_state state_{};
  std::int64_t now_ns_ = 0;
  double pressed_N_ = 0.0;
};

TEST_F(SimulatedHandTest, GripsAsHardAsItsPersonWantsByEachMethod) {
  for (const char* method : {"stick", "distance", "pinch"}) {
    ASSERT_EQ(Open(method), OOS_DEVICE_OK) << why_;
    hand_.opening_m = 0.002;
    for (const double strength_N : {5.0, 25.0}) {
      hand_.grip_strength_N = strength_N;
      Step(2000, 0.02);
      EXPECT_NEAR(pressed_N_, strength_N, 0.02) << method;
    }
    hand_.opening_m = 0.05;
    Step(1500, 0.02);
    EXPECT_NEAR(state_.opening_m, 0.05, 1e-9) << method;
    EXPECT_EQ(pressed_N_, 0.0) << method;
    table_.functions->close(device_);
    device_ = nullptr;
    state_ = {};
  }
}

// No force moves it, and the cameras see it sixty times a second, a tenth of a millimetre off.
TEST_F(SimulatedHandTest, IsWhereTheCamerasSawItsPerson) {
  ASSERT_EQ(Open(""), OOS_DEVICE_OK) << why_;
  Step(20, 0.0);
  int num_new = 0;
  double before_m = state_.X_BD[4], squares = 0.0;
  for (int i = 0; i < 3000; ++i) {
    Step(1, 0.0);
    if (state_.X_BD[4] == before_m) continue;
    before_m = state_.X_BD[4];
    for (int k = 4; k < 7; ++k) squares += state_.X_BD[k] * state_.X_BD[k];
    ++num_new;
  }
  EXPECT_NEAR(num_new, 180, 3);
  EXPECT_NEAR(std::sqrt(squares / num_new), 1e-4, 1e-5);
  hand_.X_BT[4] = 0.5;
  Step(20, 0.0);
  EXPECT_NEAR(state_.X_BD[4], 0.5, 1e-3);
}

TEST_F(SimulatedHandTest, LetsGoWithItsPerson) {
  ASSERT_EQ(Open("pinch"), OOS_DEVICE_OK) << why_;
  Step(20, 0.0);
  EXPECT_EQ(state_.flags, static_cast<std::uint32_t>(OOS_DEVICE_IS_ENGAGED));
  hand_.holds_dead_man = 0;
  Step(20, 0.0);
  EXPECT_EQ(state_.flags, 0u);
}

// It has no jaws to stop on something: the fingers press as far as the person closes them, whatever is between them.
TEST_F(SimulatedHandTest, TellsTheFingersOfItsPerson) {
  ASSERT_EQ(Open("fingers"), OOS_DEVICE_OK) << why_;
  for (const double opening_m : {0.05, 0.002}) {
    hand_.opening_m = opening_m;
    Step(2000, 0.02);
    ASSERT_EQ(state_.num_finger_joints, static_cast<std::uint32_t>(OOS_DEVICE_FINGER_JOINTS));
    const tracking::FingerAngles wanted_rad = tracking::GraspAngles(opening_m);
    for (std::size_t i = 0; i < wanted_rad.size(); ++i) EXPECT_EQ(state_.finger_rad[i], wanted_rad[i]) << i;
  }
  table_.functions->close(device_);
  ASSERT_EQ(Open("pinch"), OOS_DEVICE_OK) << why_;
  state_ = {};
  Step(20, 0.0);
  EXPECT_EQ(state_.num_finger_joints, 0U);
}

TEST_F(SimulatedHandTest, SaysWhichMethodsThereAre) {
  EXPECT_EQ(Open("fist"), OOS_DEVICE_BAD_SETTING);
  EXPECT_STREQ(why_, "option grip: 'fist' is not stick, distance, pinch or fingers");
}

}  // namespace
}  // namespace device_bridge
