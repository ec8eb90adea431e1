#include "nodes/device_bridge/tactile/body_touch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>

#include "core/clock.hpp"
#include "tactile/simulated_usb.hpp"
#include "tactile/usb_driver.hpp"

namespace device_bridge {
namespace {

constexpr std::uint16_t kForearm = 0, kWall = 1;

// From the contacts of a forearm in a scene to the motors of its bracelet, in virtual time. The forearm lies along x of
// W, and motor 0 is on top.
class BodyTouchTest : public testing::Test {
 protected:
  BodyTouchTest() {
    scenario_.objects.resize(2);
    scenario_.objects[kForearm].owner = scene::Owner::kPhysics;
    scene::Pair pair;
    pair.sampled = kForearm;
    pair.field = kWall;
    scenario_.pairs.push_back(pair);
    scene::Tactile tactile;
    tactile.body = kForearm;
    // Columns: x of B is z of W, y of B is y of W, z of B is minus x of W.
    tactile.X_OB.rotation = core::QuaternionFromRollPitchYaw({0.0, -glm::half_pi<double>(), 0.0});
    tactile.full_depth_m = 0.004;
    scenario_.tactiles.push_back(tactile);
  }
  void SetUp() override {
    const auto table = tactile::ReadUsbTable(VR_OOS_SOURCE_DIR "/scenarios/touch/vibrotac.xml");
    ASSERT_TRUE(table);
    driver_ = std::make_unique<tactile::UsbDriver>(*table, bracelet_.Connect());
    poses_.emplace(scenario_);
    touch_.emplace(scenario_, scenario_.tactiles[0]);
  }

  // A wall in this direction from the forearm's axis, in the plane across it: 0 is up, a right angle is along y.
  void Press(double angle_rad, double depth_m) {
    const glm::vec3 to_wall_W(0.0f, std::sin(angle_rad), std::cos(angle_rad));
    core::ContactPlane plane;
    plane.n_G = -to_wall_W;  // from the wall to the forearm
    plane.p_S = static_cast<float>(depth_m) * to_wall_W;
    plane.stiffness_N_per_m = 1000.0f;
    contacts_.sampled_body = kForearm;
    contacts_.field_body = kWall;
    contacts_.planes.clear();
    contacts_.planes.push_back(plane);
    is_sent_ = true;
  }

  // As the bridge's loop: contacts come every millisecond, and are looked at every fourth.
  void RunOneMs() {
    now_ns_ += core::kMillisecond_ns;
    if (is_sent_) received_ns_ = now_ns_;
    if (now_ns_ / core::kMillisecond_ns % 4 != 0 || is_bridge_hung_) return TurnDriver();
    const SeenContacts seen[] = {{received_ns_ == 0 ? nullptr : &contacts_, received_ns_}};
    touch_->Step(now_ns_, seen, *poses_);
    tactile::Strengths strengths;
    strengths.made_ns = now_ns_;
    tactile::ShareRound(touch_->towards_B(), touch_->strength(), std::span(strengths.levels).first(6));
    driver_->Take(strengths);
    TurnDriver();
  }
  // The worst phase of the driver's turns against the bridge's ticks.
  void TurnDriver() {
    if (now_ns_ / core::kMillisecond_ns % 4 == 3) driver_->Turn(now_ns_);
  }
  template <class Condition>
  double MsUntil(const Condition& is_reached) {
    const std::int64_t begin_ns = now_ns_;
    while (!is_reached() && now_ns_ - begin_ns < 1000 * core::kMillisecond_ns) RunOneMs();
    return static_cast<double>(now_ns_ - begin_ns) * 1e-6;
  }
  void Run(int ms) {
    for (int i = 0; i < ms; ++i) RunOneMs();
  }

  std::int64_t now_ns_ = 1'000'000'000;
  scene::Scenario scenario_;
  tactile::SimulatedUsb bracelet_{[this] { return now_ns_; }};
  std::unique_ptr<tactile::UsbDriver> driver_;
  std::optional<BodyPoses> poses_;
  std::optional<BodyTouch> touch_;
  core::ContactSet contacts_;
  std::int64_t received_ns_ = 0;
  bool is_sent_ = false;
  bool is_bridge_hung_ = false;
};

TEST_F(BodyTouchTest, AContactIsAtTheMotorsWithin20msInEveryPhase) {
  for (int phase = 0; phase < 4; ++phase) {
    is_sent_ = false;
    Run(100 + phase);
    ASSERT_EQ(bracelet_.motors().sum(), 0.0);
    Press(0.0, 0.002);
    EXPECT_LE(MsUntil([&] { return bracelet_.motors().sum() > 0.0; }), 20.0);
  }
}

TEST_F(BodyTouchTest, WhenContactsStopTheMotorsAreOffWithin60ms) {
  Press(0.0, 0.004);
  Run(100);
  ASSERT_GT(bracelet_.motors().sum(), 0.9);
  is_sent_ = false;
  EXPECT_LE(MsUntil([&] { return bracelet_.motors().sum() == 0.0; }), 60.0);
}

TEST_F(BodyTouchTest, WhenTheBridgeHangsTheMotorsAreOffWithin60ms) {
  Press(0.0, 0.004);
  Run(100);
  ASSERT_GT(bracelet_.motors().sum(), 0.9);
  is_bridge_hung_ = true;
  EXPECT_LE(MsUntil([&] { return bracelet_.motors().sum() == 0.0; }), 60.0);
}

// What the motors get, after the frame's bytes: the sum within 1 %, the angle within 5 degrees.
TEST_F(BodyTouchTest, TheMotorsShowWhereTheForearmIsTouched) {
  for (int degree = 0; degree < 360; degree += 5) {
    Press(glm::radians(static_cast<double>(degree)), 0.003);
    Run(12);
    const std::vector<float> levels = bracelet_.motors().levels;
    ASSERT_EQ(levels.size(), 6u);
    EXPECT_NEAR(bracelet_.motors().sum(), 0.75, 0.0075) << degree;
    // Two neighbours run, and what is felt is between them, nearer to the stronger one.
    const auto first = static_cast<std::size_t>(std::max_element(levels.begin(), levels.end()) - levels.begin());
    const double way = (static_cast<double>(levels[(first + 1) % 6]) - static_cast<double>(levels[(first + 5) % 6])) /
                       bracelet_.motors().sum();
    const double felt_deg = 60.0 * (static_cast<double>(first) + way);
    EXPECT_LT(std::abs(std::remainder(felt_deg - degree, 360.0)), 5.0) << degree;
  }
}

TEST_F(BodyTouchTest, StrengthGrowsWithTheDepthOrWithTheForceAndEndsAtAll) {
  for (const double full_force_N : {0.0, 4.0}) {
    scenario_.tactiles[0].full_force_N = full_force_N;  // 4 N is at the full depth, too
    double before = 0.0;
    for (const double depth_m : {0.001, 0.002, 0.003, 0.004, 0.008}) {
      Press(1.0, depth_m);
      Run(12);
      EXPECT_NEAR(bracelet_.motors().sum(), std::min(1.0, depth_m / 0.004), 0.01);
      EXPECT_GE(bracelet_.motors().sum(), before);
      before = bracelet_.motors().sum();
    }
  }
}

TEST_F(BodyTouchTest, ABodyThatTurnsTakesItsBraceletAlong) {
  core::PhysicsState physics;
  physics.bodies.push_back({});
  physics.bodies[0].object = kForearm;
  // A quarter turn about the forearm: what was on top is now at the side of y.
  physics.bodies[0].X_WO.rotation = core::QuaternionFromRollPitchYaw({-glm::half_pi<double>(), 0.0, 0.0});
  Inputs inputs;
  inputs.physics = &physics;
  poses_->Update(inputs);
  Press(0.0, 0.0);
  // p_S is in S, n_G in G: the wall stays above in W.
  contacts_.planes[0].p_S = {0.0f, -0.004f, 0.0f};
  Run(12);
  EXPECT_GT(touch_->strength(), 0.99);
  EXPECT_NEAR(glm::distance(touch_->towards_B(), {0.0, -1.0, 0.0}), 0.0, 1e-6);
}

}  // namespace
}  // namespace device_bridge
