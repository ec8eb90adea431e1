#pragma once

#include <memory>
#include <optional>

#include "bus/rt/worker_pool.hpp"
#include "nodes/haptic_node/node_loop.hpp"
#include "nodes/run_node/run_node.hpp"

namespace haptic_node {

// What main.cpp declares about the process.
run_node::Program MakeProgram();

// haptic_node in its process.
class Body : public run_node::Body {
 public:
  // `answer`: as NodeLoop's.
  explicit Body(const Answer* answer = nullptr) : answer_(answer) {}

  core::Result<void> Build(const run_node::Setting& setting) override;
  core::Result<void> Connect(bus::Node* node, const bus::NodeOptions& options) override;
  core::Result<run_node::StepFormat> DescribeSteps() override;
  void RecordSteps(bus::log::StepSink* sink) override { loop_->RecordSteps(sink); }
  void Run(const std::atomic<bool>& stop) override { loop_->Run(stop); }
  core::Result<void> WriteReport(bool is_realtime) override;

 protected:
  NodeLoop& loop() { return *loop_; }

 private:
  const Answer* answer_;
  const run_node::Setting* setting_ = nullptr;
  std::optional<bus::WorkerPool> pool_;
  std::unique_ptr<HapticNode> haptic_;
  std::optional<NodeLoop> loop_;
};

}  // namespace haptic_node
