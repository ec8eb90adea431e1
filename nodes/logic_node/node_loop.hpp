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

// The node that owns a parameter and applies its changes; empty: any that knows it.
std::string OwnerOf(const scene::Scenario& scenario, const std::string& parameter);

// Ties a LogicNode to the bus: 100 steps a second, each at the newest bus time, which is that of physics/state.
class NodeLoop {
 public:
  NodeLoop(const scene::Scenario& scenario, LogicNode* logic, bus::Node* node);

  // Declares what is read and written; before bus::Node::Start.
  void Declare();
  // From now on every step is written down, with all that it reads.
  void RecordSteps(bus::log::StepSink* sink);
  // A node that was lost may come back for this long before the procedure fails; 0: nobody starts it again.
  void WaitForLostNodes(std::int64_t patience_ns) { patience_ns_ = patience_ns; }
  // Writes there what a later life goes on from, at each change and ten times a second.
  void KeepCheckpoints(std::filesystem::path file) { checkpoint_ = std::move(file); }
  // Goes on from there; parameters are given to their owners again, which may have come back themselves.
  core::Result<void> Resume(const std::filesystem::path& file);
  // Runs until `stop` is set. The report is written whenever the procedure ends, and at the end.
  void Run(const std::atomic<bool>& stop, const std::filesystem::path& report);
  // The procedure's part of the run's report.
  [[nodiscard]] bool WriteReport(const std::filesystem::path& file) const;

 private:
  // A change on its way to its owner: sent again until the owner has answered, since owners may start later.
  struct Change {
    std::int64_t time_ns = 0;  // bus time
    core::ParameterChange change;
    std::string owner;
    std::uint64_t request = 0;
    std::int64_t next_try_ns = 0;
    int tries = 0;
    bool is_answered = false;
    bool is_accepted = false;
    std::uint64_t tick = 0;  // of the owner, at whose top it was applied
    std::string why;
  };

  void Listen();
  void FollowNode(const core::Event& event);
  void GiveUpLostNodes();
  void Remind(const std::string& owner);
  void SaveCheckpoint(std::int64_t now_ns);
  [[nodiscard]] std::vector<AppliedChange> Applied() const;
  void MakeStep();
  void SendChanges(std::int64_t now_ns);
  void TakeAnswers(std::int64_t now_ns);

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
