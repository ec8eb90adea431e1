#include <cstdio>
#include <limits>
#include <memory>
#include <optional>

#include "core/clock.hpp"
#include "nodes/device_bridge/device_bridge.hpp"
#include "nodes/device_bridge/node_loop.hpp"
#include "nodes/run_node/run_node.hpp"

namespace {

class DeviceBridgeBody final : public run_node::Body {
 public:
  core::Result<void> Build(const run_node::Setting& setting) override {
    setting_ = &setting;
    seed_ = setting.arguments.has("--seed") ? setting.arguments.checked_count("--seed") : setting.scenario.seed;
    device_bridge::Options options;
    options.clock = core::MonotonicNow_ns;
    auto bridge = device_bridge::DeviceBridge::Create(setting.scenario, seed_, options);
    if (!bridge) return tl::unexpected(bridge.error());
    bridge_ = std::move(*bridge);
    return {};
  }
  core::Result<void> Connect(bus::Node* node, const bus::NodeOptions& /*options*/) override {
    loop_.emplace(setting_->scenario, seed_, bridge_.get(), node);
    loop_->Declare();
    return {};
  }
  void OnStart() override {
    const auto& devices = setting_->scenario.devices;
    for (std::size_t role = 0; role < devices.size(); ++role) {
      std::printf("role %s: %s\n", devices[role].role.c_str(), bridge_->device(role).description());
    }
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed_));
  }
  void Run(const std::atomic<bool>& stop) override { loop_->Run(stop); }
  core::Result<void> WriteReport(bool is_realtime) override { return loop_->WriteReport(setting_->out, is_realtime); }

 private:
  const run_node::Setting* setting_ = nullptr;
  std::uint64_t seed_ = 0;
  std::unique_ptr<device_bridge::DeviceBridge> bridge_;
  std::optional<device_bridge::NodeLoop> loop_;
};

}  // namespace

int main(int argc, char** argv) {
  run_node::Program program;
  program.name = "device_bridge";
  program.summary = "the devices of the operators' hands, simulated, behind the safety filter; 1 kHz";
  program.options = {{"--seed", "N", "of the simulated operator; default: the scenario's", "",
                      cli::Count(0, std::numeric_limits<std::uint64_t>::max())}};
  program.thread = "device-rt";
  // Above the haptic node: a sample or a write takes some microseconds and starts or closes the loop.
  program.fifo_priority = 85;
  program.can_record_steps = false;
  program.ready = "devices are simulated";
  return run_node::RunNode(argc, argv, program, std::make_unique<DeviceBridgeBody>());
}
