#include "tools/failures/loop.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "core/clock.hpp"
#include "core/testing/allocations.hpp"
#include "tools/failures/scene_kit.hpp"

namespace failures {

Loop::Loop(const scene::Scenario& scenario, const LoopOptions& options) : scenario_(scenario), options_(options) {
  const SetUpLock lock;
  if (!scenario_.devices.empty()) {
    scenario_.operator_script = WorkFolder() / "operator.txt";
    std::ofstream(scenario_.operator_script) << "step a\nrole " << scenario_.devices[0].role << "\n"
                                             << options.script << "\n";
    device_bridge::Options bridge_options;
    bridge_options.operator_options.tremor_m = options.tremor_m;
    bridge_options.num_echoes = 1;  // latencies are not measured here
    bridge_options.is_made_passive = options.is_made_passive;
    bridge_ = Must(device_bridge::DeviceBridge::Create(scenario_, options.seed, bridge_options));
  }
  logic_.step = "a";
  if (options.answer) return;
  haptic_node::Options haptic_options;
  haptic_options.collision.cache = WorkFolder() / "cache";
  haptic_options.budget_ns = options.budget_ns;
  haptic_ = Must(haptic_node::HapticNode::Create(scenario_, serial_, haptic_options));
  haptic_->PrepareOutputs(&out_);
  contacts_.resize(scenario_.pairs.size());
  const bool has_bodies = std::any_of(scenario_.objects.begin(), scenario_.objects.end(),
                                      [](const scene::Object& o) { return o.owner == scene::Owner::kPhysics; });
  if (has_bodies) {
    physics_node::Options physics_options;
    physics_options.collision.cache = haptic_options.collision.cache;
    physics_ = Must(physics_node::PhysicsNode::Create(scenario_, physics_options));
  }
}

void Loop::Tick() {
  now_ns_ += core::kTick_ns;
  ++ticks_;
  if (bridge_ != nullptr) StepBridge();
  StepHaptic();
  if (bridge_ != nullptr) {
    commands_.push_back(out_.commands);
    if (static_cast<int>(commands_.size()) > options_.command_delay_ticks) {
      if (is_linked_) {
        for (std::size_t i = 0; i < commands_.front().size(); ++i)
          bridge_->AcceptCommand(i, commands_.front()[i], now_ns_ + kAnswer_ns, now_ns_ + kAnswer_ns);
      }
      commands_.pop_front();
    }
    exerted_before_ = exerted();
  }
  if (physics_ != nullptr) StepPhysics();
}

void Loop::Prescribe(std::span<const core::Pose> X_WDs, bool is_engaged) {
  now_ns_ += core::kTick_ns;
  ++ticks_;
  const auto before = devices_;
  devices_.clear();
  for (std::size_t i = 0; i < X_WDs.size(); ++i) {
    core::DeviceState device;
    device.role_index = static_cast<std::uint8_t>(i);
    device.header.sequence = ticks_;
    device.header.publish_ns = device.sample_ns = now_ns_;
    device.is_engaged = is_engaged;
    device.opening_m = opening_m_;
    device.X_WD = X_WDs[i];
    if (i < before.size()) {
      const core::Pose& last = before[i].X_WD;
      const double per_s = 1e9 / static_cast<double>(core::kTick_ns);
      device.V_WD = {per_s * core::RotationVector(X_WDs[i].rotation * glm::conjugate(last.rotation)),
                     per_s * (X_WDs[i].translation - last.translation)};
    }
    devices_.push_back(device);
  }
  StepHaptic();
  if (physics_ != nullptr) StepPhysics();
}

void Loop::Run(double seconds) {
  const long num_ticks = std::lround(1000.0 * seconds);
  for (long i = 0; i < num_ticks; ++i) Tick();
}

core::Wrench Loop::exerted() const {
  return bridge_->device(0).Felt().F_Do_W;
}

const core::BodyState& Loop::body(std::uint16_t object) const {
  return *std::find_if(physics_out_.state.bodies.begin(), physics_out_.state.bodies.end(),
                       [object](const core::BodyState& b) { return b.object == object; });
}

void Loop::StepBridge() {
  device_bridge::Inputs inputs;
  inputs.now_ns = now_ns_;
  inputs.proxies = out_.proxies;
  inputs.physics = physics_ != nullptr && ticks_ > 1 ? &physics_out_.state : nullptr;
  for (const core::Reaction& reaction : reactions_) inputs.grasped_objects.push_back(reaction.grasped_object);
  inputs.logic = &logic_;
  device_bridge::Outputs outputs;
  bridge_->Step(inputs, &outputs);
  devices_ = outputs.states;
  if (!is_held_) TakeHandAlong();
  constexpr double kShare = static_cast<double>(kAnswer_ns) / static_cast<double>(core::kTick_ns);
  energy_.Add(devices_[0], kShare * exerted_at_sample_ + (1.0 - kShare) * exerted_before_, scenario_.devices[0]);
  exerted_at_sample_ = exerted();
}

// A target that moves with the device pulls at nothing. The bridge gives its devices only to look at; the hand is ours.
void Loop::TakeHandAlong() {
  device_bridge::HandTarget target = bridge_->simulated_operator().target(0);
  target.X_WT = devices_[0].X_WD;
  target.V_WT = devices_[0].V_WD;
  const_cast<device_bridge::Device&>(bridge_->device(0)).SetHand(target);
}

void Loop::StepHaptic() {
  if (options_.answer) {
    out_.commands.resize(1);
    out_.commands[0].header.direct = devices_[0].header.direct;
    out_.commands[0].F_Do_W = options_.answer(devices_[0]);
  } else {
    haptic_node::Inputs inputs;
    inputs.now_ns = now_ns_;
    inputs.devices = devices_;
    inputs.physics = physics_ != nullptr && ticks_ > 1 ? &physics_out_.state : nullptr;
    inputs.reactions = reactions_;
    inputs.budget_points = options_.budget_points;
    const std::uint64_t allocations = core::test::NumAllocationsOfThread();
    const std::int64_t begin_ns = core::ThreadCpuNow_ns();
    haptic_->Step(inputs, &out_);
    haptic_cpu_ns_ = core::ThreadCpuNow_ns() - begin_ns;
    haptic_allocations_ = core::test::NumAllocationsOfThread() - allocations;
  }
  for (core::DeviceCommand& command : out_.commands) {
    command.header.sequence = ticks_;
    command.header.publish_ns = now_ns_;
  }
  for (core::HapticProxy& proxy : out_.proxies) {
    proxy.header.sequence = ticks_;
    proxy.header.publish_ns = now_ns_;
  }
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (out_.contacts_updated[i] == 0) continue;
    contacts_[i] = out_.contacts[i];
    contacts_[i].header.sequence = ticks_;
    contacts_[i].header.publish_ns = now_ns_;
  }
}

void Loop::StepPhysics() {
  cycles_.push_back({out_.proxies, contacts_});
  if (static_cast<int>(cycles_.size()) > options_.physics_delay_ticks + 1) cycles_.pop_front();
  physics_node::Inputs inputs;
  inputs.now_ns = now_ns_;
  inputs.proxies = cycles_.front().proxies;
  inputs.contacts = cycles_.front().contacts.data();
  inputs.num_contacts = cycles_.front().contacts.size();
  const std::int64_t begin_ns = core::ThreadCpuNow_ns();
  physics_->Step(inputs, &physics_out_);
  physics_cpu_ns_ = core::ThreadCpuNow_ns() - begin_ns;
  physics_out_.state.header.sequence = ticks_;
  physics_out_.state.header.publish_ns = now_ns_;
  for (core::Reaction& reaction : physics_out_.reactions) {
    reaction.header.sequence = ticks_;
    reaction.header.publish_ns = now_ns_;
  }
  reactions_ = physics_out_.reactions;
}

}  // namespace failures
