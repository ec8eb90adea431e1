#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <vector>

#include "bus/node.hpp"
#include "nodes/logic_node/checkpoint.hpp"
#include "nodes/logic_node/logic_node.hpp"
#include "nodes/logic_node/step.hpp"
#include "replay/step_recorder.hpp"

namespace logic_node {

// The node that owns a parameter and applies its changes; empty: every node that knows it.
std::string OwnerOf(const scene::Scenario& scenario, const std::string& parameter);

// Connects a LogicNode to the bus: 100 steps per second, each at the newest bus time, which is that of physics/state.
class NodeLoop {
 public:
  NodeLoop(const scene::Scenario& scenario, LogicNode* logic, bus::Node* node);

  // Declares the topics that are read and written; call it before bus::Node::Start.
  void Declare();
  // Records every following step with all its inputs.
  void RecordSteps(bus::log::StepSink* sink);
  // How long a lost node may take to return before the procedure fails; 0: no supervisor restarts it.
  void WaitForLostNodes(std::int64_t patience_ns) { patience_ns_ = patience_ns; }
  // Writes a checkpoint to this file at each change and ten times per second.
  void KeepCheckpoints(std::filesystem::path file) { checkpoint_ = std::move(file); }
  // Continues from a checkpoint. Sends the parameters again, since their owners may have restarted too. Errors: as
  // ReadCheckpoint and LogicNode::Restore.
  core::Result<void> Resume(const std::filesystem::path& file);
  // Runs until `stop` is set. Writes the report when the procedure ends.
  void Run(const std::atomic<bool>& stop, const std::filesystem::path& report);
  // Writes the procedure's part of the run's report.
  [[nodiscard]] bool WriteReport(const std::filesystem::path& file) const;

 private:
  // A parameter change and its delivery: sent again until the owner has answered, since owners may start later.
  struct Change {
    std::int64_t time_ns = 0;  // bus time
    core::ParameterChange change;
    std::string owner;
    std::uint64_t request = 0;
    std::int64_t next_try_ns = 0;
    int tries = 0;
    bool is_answered = false;
    bool is_accepted = false;
    std::uint64_t tick = 0;  // of the owner, at the start of which it was applied
    std::string why;
  };

  void ReceiveEvents();
  void TrackNode(const core::Event& event);
  void ReportGoneNodes();
  void ResendParameters(const std::string& owner);
  void SaveCheckpoint(std::int64_t now_ns);
  [[nodiscard]] std::vector<AppliedChange> Applied() const;
  void MakeStep();
  void SendChanges(std::int64_t now_ns);
  void ReceiveAcks(std::int64_t now_ns);

  const scene::Scenario& scenario_;
  LogicNode* logic_;
  bus::Node* node_;
  bus::LatestReader<core::PhysicsState>* physics_ = nullptr;
  std::vector<bus::LatestReader<core::Reaction>*> reactions_;
  bus::StateWriter<core::LogicStatus> status_writer_;
  std::vector<Change> changes_;
  std::int64_t next_status_ns_ = 0;
  std::map<std::string, std::int64_t> lost_since_ns_;
  std::int64_t patience_ns_ = 0;
  std::filesystem::path checkpoint_;  // empty: none
  std::int64_t next_checkpoint_ns_ = 0;
  bool is_checkpoint_refused_ = false;
  Step step_;
  Inputs& inputs_ = step_.inputs;
  Outputs& outputs_ = step_.outputs;
  std::unique_ptr<replay::StepRecorder<Step>> recorder_;  // null: steps are not recorded
  std::uint64_t num_steps_ = 0;
};

}  // namespace logic_node
