#pragma once

#include <memory>
#include <optional>

#include "bus/rt/worker_pool.hpp"
#include "nodes/physics_node/node_loop.hpp"
#include "nodes/physics_node/sheet_thread.hpp"
#include "nodes/run_node/run_node.hpp"

namespace physics_node {

// What main.cpp declares about the process.
run_node::Program MakeProgram();

// physics_node in its process.
class Body final : public run_node::Body {
 public:
  // `cycle`: as NodeLoop's.
  explicit Body(Cycle* cycle = nullptr) : cycle_(cycle) {}

  core::Result<void> Build(const run_node::Setting& setting) override;
  core::Result<void> Connect(bus::Node* node, const bus::NodeOptions& options) override;
  core::Result<run_node::StepFormat> DescribeSteps() override;
  void RecordSteps(bus::log::StepSink* sink) override { loop_->RecordSteps(sink); }
  void Run(const std::atomic<bool>& stop) override { loop_->Run(stop); }
  core::Result<void> WriteReport(bool is_realtime) override;
  NodeLoop& loop() { return *loop_; }

 private:
  core::Result<void> Restore();

  Cycle* cycle_;
  const run_node::Setting* setting_ = nullptr;
  std::optional<bus::WorkerPool> pool_;
  std::optional<SheetThread> sheet_thread_;  // outlives the node that it works for
  std::unique_ptr<PhysicsNode> physics_;
  Snapshot snapshot_;
  bool is_restored_ = false;
  std::optional<NodeLoop> loop_;
};

}  // namespace physics_node
