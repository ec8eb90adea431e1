#pragma once

#include <filesystem>
#include <memory>

#include "bus/log/step_log.hpp"
#include "nodes/haptic_node/step.hpp"
#include "nodes/logic_node/logic_node.hpp"
#include "nodes/logic_node/step.hpp"
#include "nodes/physics_node/physics_node.hpp"
#include "nodes/physics_node/step.hpp"
#include "replay/step_recorder.hpp"
#include "scene/scenario.hpp"

namespace lockstep {

// The steps of all nodes of a run in lock-step, in one file.
class StepRecording {
 public:
  // With the checkpoints of physics_node and logic_node as they stand; haptic_node must not have stepped yet.
  static core::Result<std::unique_ptr<StepRecording>> Create(const std::filesystem::path& path,
                                                             const scene::Scenario& scenario,
                                                             const physics_node::PhysicsNode& physics,
                                                             const logic_node::LogicNode& logic);
  core::Result<void> Close();

 private:
  class Sink final : public bus::log::StepSink {
   public:
    bool Push(std::uint64_t tick, std::int64_t now_ns, std::span<const std::uint8_t> step) noexcept override;
    bus::log::StepFile* file = nullptr;
    std::uint16_t channel = 0;
    core::Result<void> done;
  };
  explicit StepRecording(std::unique_ptr<bus::log::StepFile> file) : file_(std::move(file)) {}

  std::unique_ptr<bus::log::StepFile> file_;
  Sink haptic_sink_, physics_sink_, logic_sink_;

 public:
  replay::StepRecorder<haptic_node::Step> haptic{&haptic_sink_};
  replay::StepRecorder<haptic_node::Step> reevaluation{&haptic_sink_, haptic_node::kReevaluation};
  replay::StepRecorder<physics_node::Step> physics{&physics_sink_};
  replay::StepRecorder<logic_node::Step> logic{&logic_sink_};
};

}  // namespace lockstep
