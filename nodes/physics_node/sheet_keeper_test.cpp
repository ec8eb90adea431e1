#include "nodes/physics_node/sheet_keeper.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <thread>

#include "core/clock.hpp"
#include "nodes/physics_node/physics_node.hpp"
#include "nodes/physics_node/sheet_thread.hpp"
#include "scene/load_scenario.hpp"

namespace physics_node {
namespace {

// The cover of module_replacement, with the hand at the test's poses. No contact planes are needed: sheets detect their
// own contacts.
class SheetTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto loaded = scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios/module_replacement");
    ASSERT_TRUE(loaded.has_value());
    scenario_ = *loaded;
    Create();
  }
  void Create() {
    auto made = PhysicsNode::Create(scenario_);
    ASSERT_TRUE(made.has_value()) << made.error().detail;
    node_ = std::move(*made);
    cover_ = scenario_.FindObject("cover");
    X_WD_ = scenario_.devices[0].X_WD_start;
    opening_m_ = 0.05;
    inputs_.proxies.resize(1);
  }
  void Tick() {
    ++cycle_;
    inputs_.now_ns += core::kTick_ns;
    core::HapticProxy& proxy = inputs_.proxies[0];
    proxy.header.sequence = cycle_;
    proxy.cycle = cycle_;
    proxy.X_WD = X_WD_;
    proxy.X_WC = X_WD_;
    proxy.opening_m = opening_m_;
    node_->Step(inputs_, &outputs_);
    inputs_.num_changes = 0;
    for (const core::Event& event : outputs_.events) events_.push_back(event.name + " " + event.detail);
  }
  void MoveTo(const glm::dvec3& p_W, int ticks) {
    const glm::dvec3 start_W = X_WD_.translation;
    for (int i = 1; i <= ticks; ++i) {
      X_WD_.translation = glm::mix(start_W, p_W, static_cast<double>(i) / ticks);
      Tick();
    }
  }
  int StateOf(const char* mechanism) {
    const int index = scenario_.FindMechanism(mechanism);
    for (const core::MechanismState& state : outputs_.state.mechanisms) {
      if (state.mechanism == index) return state.state;
    }
    return -1;
  }
  core::SheetState Shown() {
    core::SheetState state;
    node_->sheets().FillState(0, node_->tick(), &state);
    return state;
  }
  // The hand beside the sheet's border at y = -85 mm, turned so that its fingers point along +y: the jaws close on the
  // sheet from above and below.
  void PinchBorder() {
    X_WD_.rotation = glm::angleAxis(glm::radians(90.0), glm::dvec3(1, 0, 0)) *
                     glm::angleAxis(glm::radians(90.0), glm::dvec3(0, 0, 1));
    X_WD_.translation = {0.17, -0.079, 0.0495};
    for (int i = 0; i < 20; ++i) Tick();
    for (int i = 0; i < 200; ++i) {
      opening_m_ = std::max(0.002, 0.05 - 0.0005 * i);
      Tick();
    }
  }

  scene::Scenario scenario_;
  std::unique_ptr<PhysicsNode> node_;
  Inputs inputs_;
  Outputs outputs_;
  std::vector<std::string> events_;
  core::Pose X_WD_;
  double opening_m_ = 0.05;
  std::uint64_t cycle_ = 0;
  int cover_ = -1;
};

TEST_F(SheetTest, JawsPinchTheSheetPeelItOffAndFeelItsForce) {
  PinchBorder();
  EXPECT_EQ(outputs_.reactions[0].grasped_object, cover_);
  EXPECT_EQ(StateOf("cover_hold"), 2);
  double peak_N = 0.0;
  const glm::dvec3 start_W = X_WD_.translation;
  for (int i = 1; i <= 20; ++i) {
    MoveTo(start_W + glm::dvec3(0.0, 0.0, 0.005 * i), 50);
    peak_N = std::max(peak_N, -outputs_.reactions[0].F_Do_W.force_N.z);
  }
  EXPECT_LT(StateOf("cover_hold"), 2);  // the hook next to the hand has let go
  EXPECT_GT(peak_N, 1.0);               // the hand was pulled back down
  EXPECT_LT(peak_N, 8.0);               // no more than two hooks can pull
  opening_m_ = 0.02;
  for (int i = 0; i < 10; ++i) Tick();
  EXPECT_EQ(outputs_.reactions[0].grasped_object, core::kNoObject);
  EXPECT_EQ(std::count(events_.begin(), events_.end(), "grasp_attached right cover"), 1);
  EXPECT_EQ(events_.back(), "grasp_detached right cover");
}

TEST_F(SheetTest, TheHandPressesOnTheSheetWithoutPenetrating) {
  opening_m_ = 0.0;
  X_WD_.translation = {0.04, 0.0, 0.1};
  for (int i = 0; i < 10; ++i) Tick();
  MoveTo({0.04, 0.0, 0.02}, 400);  // fingertips 37 mm below where the sheet was
  EXPECT_GT(outputs_.reactions[0].F_Do_W.force_N.z, 0.2);
  float lowest = 1.0f;
  for (const glm::vec3& p : Shown().p_W) {
    if (std::abs(p.x - 0.04f) < 0.010f && std::abs(p.y) < 0.008f) lowest = std::min(lowest, p.z);
  }
  EXPECT_LT(lowest, 0.0125f + 0.002f);  // pushed down with the fingertips
}

TEST_F(SheetTest, AnInactiveSheetNeitherMovesNorExertsForcesNorIsStepped) {
  PinchBorder();
  MoveTo(X_WD_.translation + glm::dvec3(0.0, 0.0, 0.01), 100);
  ASSERT_GT(glm::length(outputs_.reactions[0].F_Do_W.force_N), 0.05);
  const core::ParameterChange change{"sheet.cover.active", 0.0};
  ASSERT_TRUE(node_->AcceptsParameter(change));
  inputs_.changes = &change;
  inputs_.num_changes = 1;
  for (int i = 0; i < 5; ++i) Tick();
  const core::SheetState before = Shown();
  const std::uint64_t steps = node_->sheets().num_steps();
  MoveTo(X_WD_.translation + glm::dvec3(0.0, 0.0, 0.05), 100);
  EXPECT_EQ(node_->sheets().num_steps(), steps);
  EXPECT_EQ(outputs_.reactions[0].F_Do_W.force_N, glm::dvec3(0.0));
  const core::SheetState after = Shown();
  for (std::size_t i = 0; i < before.p_W.size(); ++i) ASSERT_EQ(before.p_W[i], after.p_W[i]);
}

TEST_F(SheetTest, TheResultOnAThreadOfItsOwnIsTheSame) {
  PinchBorder();
  MoveTo(X_WD_.translation + glm::dvec3(0.0, 0.0, 0.03), 200);
  const std::uint64_t at_once = node_->StateHash();
  const core::SheetState shown = Shown();

  SheetThread thread(bus::RealTimeMode::kOff, 1);
  cycle_ = 0;
  inputs_ = {};
  Create();
  class Patient final : public SheetRunner {  // each step is done before the next tick looks
   public:
    explicit Patient(SheetThread* sheets) : sheets_(sheets) {}
    void Start(void (*step)(void*), void* context) override { sheets_->Start(step, context); }
    bool IsIdle() const override {
      sheets_->WaitUntilIdle();
      return true;
    }
    void WaitUntilIdle() override { sheets_->WaitUntilIdle(); }

   private:
    SheetThread* sheets_;
  } patient(&thread);
  node_->sheets().set_runner(&patient);
  PinchBorder();
  MoveTo(X_WD_.translation + glm::dvec3(0.0, 0.0, 0.03), 200);
  EXPECT_EQ(node_->StateHash(), at_once);
  for (std::size_t i = 0; i < shown.p_W.size(); ++i) ASSERT_EQ(shown.p_W[i], Shown().p_W[i]);
  EXPECT_EQ(node_->sheets().num_late(), 0u);
  node_.reset();
}

TEST_F(SheetTest, ALateStepKeepsItsForcesAndIsCounted) {
  class Never final : public SheetRunner {
   public:
    void Start(void (*)(void*), void*) override { is_idle_ = false; }
    bool IsIdle() const override { return is_idle_; }
    void WaitUntilIdle() override {}

   private:
    bool is_idle_ = true;
  } never;
  node_->sheets().set_runner(&never);
  for (int i = 0; i < 20; ++i) Tick();
  EXPECT_EQ(node_->sheets().num_steps(), 1u);
  EXPECT_EQ(node_->sheets().num_late(), 9u);
  node_.reset();
}

TEST_F(SheetTest, ARestoredNodeContinuesBitForBit) {
  PinchBorder();
  Snapshot snapshot;
  node_->Save(&snapshot);
  const glm::dvec3 goal_W = X_WD_.translation + glm::dvec3(0.0, 0.02, 0.04);
  const core::Pose start = X_WD_;
  MoveTo(goal_W, 300);
  const std::uint64_t first = node_->StateHash();
  const core::SheetState shown = Shown();
  ASSERT_TRUE(node_->Restore(&snapshot).has_value());
  X_WD_ = start;
  MoveTo(goal_W, 300);
  EXPECT_EQ(node_->StateHash(), first);
  for (std::size_t i = 0; i < shown.p_W.size(); ++i) ASSERT_EQ(shown.p_W[i], Shown().p_W[i]);
}

TEST_F(SheetTest, RefusesAPatchBesideTheSheetWithItsLine) {
  scenario_.mechanisms[static_cast<std::size_t>(scenario_.FindMechanism("cover_hold_b"))].patches_m.push_back(
      {1, 1, 0});
  const auto made = PhysicsNode::Create(scenario_);
  ASSERT_FALSE(made.has_value());
  EXPECT_NE(made.error().detail.find("cover_hold_b"), std::string::npos) << made.error().detail;
  EXPECT_NE(made.error().detail.find("scenario.xml:"), std::string::npos) << made.error().detail;
}

}  // namespace
}  // namespace physics_node
