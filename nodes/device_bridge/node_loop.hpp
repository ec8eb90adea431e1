#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bus/node.hpp"
#include "bus/rt/latency_stats.hpp"
#include "core/messages/viewing.hpp"
#include "nodes/device_bridge/device_bridge.hpp"
#include "nodes/device_bridge/force_log.hpp"
#include "nodes/device_bridge/head/head_tracker.hpp"
#include "nodes/device_bridge/head/head_watch.hpp"
#include "nodes/device_bridge/tactile/tactiles.hpp"

namespace device_bridge {

// Connects a DeviceBridge to the bus: samples at 1 kHz of absolute time, and between ticks passes every command to the
// device as soon as it arrives.
class NodeLoop {
 public:
  // `heads`: of the scenario's users; `tactiles`: of the scenario, or none. `viewers`: names of the nodes by which a
  // person may steer; at most kMaxViewers.
  NodeLoop(const scene::Scenario& scenario, std::vector<std::unique_ptr<HeadTracker>> heads,
           std::unique_ptr<Tactiles> tactiles, DeviceBridge* bridge, bus::Node* node,
           std::vector<std::string> viewers = {});

  // Declares the topics that are read and written; call it before bus::Node::Start.
  void Declare();
  // Runs until `stop` is set.
  void Run(const std::atomic<bool>& stop);

  // <folder>/device_bridge.json, device_bridge_latency.csv and device_bridge_force.csv (see README.md of this room).
  core::Result<void> WriteReport(const std::filesystem::path& folder, bool is_realtime) const;

 private:
  void ForwardCommands();
  void Step();
  void SendHeads();
  void ReportHead(HeadWatch::News news, const HeadTracker& tracker);
  void ReportFaults(std::int64_t now_ns);
  void PublishFigures(std::int64_t now_ns);
  void TakeTips();
  void TakeMuscles();
  void ReportDevices(std::int64_t now_ns);
  void PublishHealth();
  void SendJoints();

  const scene::Scenario& scenario_;
  DeviceBridge* bridge_;
  bus::Node* node_;
  std::vector<bus::LatestReader<core::DeviceCommand>*> commands_;
  std::vector<bus::LatestReader<core::HapticProxy>*> proxies_;
  std::vector<bus::LatestReader<core::Reaction>*> reactions_;
  std::vector<std::string> viewers_;
  std::vector<bus::LatestReader<core::HandInput>*> hands_;
  bus::LatestReader<core::PhysicsState>* physics_ = nullptr;
  bus::StateReader<core::LogicStatus>* logic_ = nullptr;
  std::vector<bus::LatestWriter<core::DeviceState>> writers_;
  std::vector<std::optional<bus::LatestWriter<core::DeviceJoints>>>
      joints_writers_;         // of roles whose device is a robot
  core::DeviceJoints joints_;  // as published
  struct Head {
    std::unique_ptr<HeadTracker> tracker;
    bus::LatestWriter<core::HeadState> writer;
    HeadWatch watch;
  };
  std::vector<Head> heads_;  // of the scenario's users
  std::unique_ptr<Tactiles> tactiles_;
  std::vector<bus::StateWriter<core::DeviceHealth>> health_writers_;
  std::vector<core::DeviceHealth> health_;            // as published
  std::vector<DeviceStatus> reported_device_status_;  // per role
  bus::StateWriter<bus::Figures> figures_writer_;
  bus::Figures figures_;
  std::size_t first_share_ = 0;  // in figures_: of each role, what haptic_node limits its stiffness by

  std::size_t first_muscle_ = 0;  // in figures_: of each role, what its muscles tell

  std::size_t first_tip_ = 0;  // in figures_, while a person steers: of each role, where it goes next

  Inputs inputs_;
  Outputs outputs_;
  std::vector<std::uint32_t> reported_status_;  // per role
  core::Event silent_event_, back_event_, fault_event_;
  core::Event received_event_;
  std::vector<std::string> lost_;  // names of lost nodes
  std::int64_t next_figures_ns_ = 0;
  std::int64_t next_health_ns_ = 0;

  ForceLog force_log_;
  bus::LatencyStats step_duration_;
  bus::LatencyStats wake_delay_;
  std::uint64_t ticks_ = 0;
  std::uint64_t misses_ = 0;   // samples taken more than half a period after their tick
  std::uint64_t skipped_ = 0;  // ticks without a sample
};

}  // namespace device_bridge
