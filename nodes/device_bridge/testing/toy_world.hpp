#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <memory>
#include <string>

#include "nodes/device_bridge/device_bridge.hpp"

namespace device_bridge {

// For tests: the smallest world that closes the loop round a bridge with one role, one tick behind. Object 0 `thing`
// and 1 `goal` are bodies with a frame `spot` each; mechanism 0 `latch` is a snap, 1 `switch` a hinge; logic shows
// `step`.
struct ToyWorld {
  scene::Scenario scenario;
  std::unique_ptr<DeviceBridge> bridge;
  std::int64_t now_ns = 1'000'000'000;
  core::PhysicsState physics;
  core::LogicStatus logic;
  Outputs outputs;
  core::DeviceCommand command;
  std::int64_t received_ns = 0;
  std::uint16_t grasped = core::kNoObject;
  core::FixedVector<core::HandInput, kMaxViewers> hands;  // of viewers
  bool is_linked = true;
  bool has_physics = true;  // false: physics has died, its last state is still there
  // Force on the hand, and on the jaws, for a device state.
  std::function<core::Wrench(const core::DeviceState&)> contact;
  std::function<double(const core::DeviceState&)> jaws;
  std::function<void(ToyWorld&)> after;  // once per tick, e.g. carries a held body along

  explicit ToyWorld(const std::string& script, std::uint64_t seed = 1,
                    const std::function<void(scene::Scenario&)>& change = {}, const Options& options = {}) {
    scenario.name = "toy";
    scenario.objects.resize(2);
    scenario.objects[0].name = "thing";
    scenario.objects[1].name = "goal";
    for (scene::Object& object : scenario.objects) {
      object.owner = scene::Owner::kPhysics;
      object.frames.push_back({"spot", {{1, 0, 0, 0}, {0.0, 0.0, 0.02}}});
    }
    scenario.mechanisms.resize(2);
    scenario.mechanisms[0].name = "latch";
    scenario.mechanisms[0].kind = scene::MechanismKind::kSnap;
    scenario.mechanisms[1].name = "switch";
    scenario.devices.resize(1);
    scenario.devices[0].role = "right";
    const ::testing::TestInfo* info = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string file = std::string("device_bridge_") + info->test_suite_name() + "_" + info->name() + ".txt";
    std::replace(file.begin(), file.end(), '/', '_');  // in names of tests with parameters
    scenario.operator_script = ::testing::TempDir() + file;
    std::ofstream(scenario.operator_script) << script;
    if (change) change(scenario);
    auto created = DeviceBridge::Create(scenario, seed, options);
    if (!created) {
      ADD_FAILURE() << created.error().detail;
      return;
    }
    bridge = std::move(*created);
    physics.header.sequence = 1;
    for (std::uint16_t i = 0; i < 2; ++i) physics.bodies.push_back({i, core::Pose{}, core::Twist{}});
    for (std::uint16_t i = 0; i < 2; ++i) physics.mechanisms.push_back({i, 0, 0.0, 0.0});
    logic.step = "a";
  }

  void Tick() {
    now_ns += 1'000'000;
    if (has_physics) ++physics.header.sequence;
    Inputs inputs;
    inputs.now_ns = now_ns;
    if (command.header.sequence != 0) {
      inputs.commands.push_back(command);
      inputs.command_received_ns.push_back(received_ns);
    }
    inputs.physics = &physics;
    inputs.grasped_objects.push_back(grasped);
    inputs.logic = &logic;
    inputs.hands = hands;
    bridge->Step(inputs, &outputs);
    const core::DeviceState& state = outputs.states[0];
    if (is_linked) {
      ++command.header.sequence;
      command.header.direct = state.header.direct;
      command.F_Do_W = contact ? contact(state) : core::Wrench{};
      command.grip_force_N = jaws ? jaws(state) : 0.0;
      received_ns = now_ns;
    }
    if (after) after(*this);
  }
  void Run(double seconds) {
    const long num_ticks = std::lround(seconds * 1000.0);
    for (long i = 0; i < num_ticks; ++i) Tick();
  }
  // True when `count` lines of the script were ended in time.
  bool RunLines(std::size_t count, double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 1000.0) && records().size() < count; ++i) Tick();
    return records().size() >= count;
  }
  [[nodiscard]] const std::vector<LineRecord>& records() const { return bridge->simulated_operator().records(); }
  [[nodiscard]] const core::Pose& X_WD() const { return outputs.states[0].X_WD; }
};

}  // namespace device_bridge
