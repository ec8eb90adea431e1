#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "bus/node.hpp"
#include "bus/rt/latency_stats.hpp"
#include "nodes/device_bridge/device_bridge.hpp"
#include "nodes/device_bridge/force_log.hpp"

namespace device_bridge {

// Ties a DeviceBridge to the bus: samples at 1 kHz of absolute time, and between the ticks brings every command to the
// device the moment it arrives.
class NodeLoop {
 public:
  NodeLoop(const scene::Scenario& scenario, DeviceBridge* bridge, bus::Node* node);

  // Declares what is read and written; before bus::Node::Start.
  void Declare();
  // Runs until `stop` is set.
  void Run(const std::atomic<bool>& stop);

  // <folder>/device_bridge.json, device_bridge_latency.csv and device_bridge_force.csv (see README.md of this room).
  core::Result<void> WriteReport(const std::filesystem::path& folder, bool is_realtime) const;

 private:
  void TakeCommands();
  void Step();
  void TellFaults(std::int64_t now_ns);
  void TellFigures(std::int64_t now_ns);

  const scene::Scenario& scenario_;
  DeviceBridge* bridge_;
  bus::Node* node_;
  std::vector<bus::LatestReader<core::DeviceCommand>*> commands_;
  std::vector<bus::LatestReader<core::HapticProxy>*> proxies_;
  std::vector<bus::LatestReader<core::Reaction>*> reactions_;
  bus::LatestReader<core::PhysicsState>* physics_ = nullptr;
  bus::StateReader<core::LogicStatus>* logic_ = nullptr;
  std::vector<bus::LatestWriter<core::DeviceState>> writers_;
  bus::StateWriter<bus::Figures> figures_writer_;
  bus::Figures figures_;

  Inputs inputs_;
  Outputs outputs_;
  std::vector<std::uint32_t> told_status_;  // per role
  core::Event silent_event_, back_event_, fault_event_;
  core::Event heard_event_;
  std::vector<std::string> lost_;  // nodes that were lost, by name
  std::int64_t next_figures_ns_ = 0;

  ForceLog force_log_;
  bus::LatencyStats step_duration_;
  bus::LatencyStats wake_delay_;
  std::uint64_t ticks_ = 0;
  std::uint64_t misses_ = 0;   // samples taken later than half a millisecond after their tick
  std::uint64_t skipped_ = 0;  // ticks that never were
};

}  // namespace device_bridge
