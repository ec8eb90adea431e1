#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>
#include <vector>

#include "core/clock.hpp"
#include "nodes/device_bridge/device_bridge.hpp"
#include "nodes/device_bridge/head/make_heads.hpp"
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
    options.is_person_steering = setting.arguments.text("--hand") == "pointer";
    options.threads.emplace();
    options.threads->rt = setting.mode;
    options.threads->find_calibration = device_bridge::KeptCalibration;
    scenario_ = setting.scenario;
    const auto chosen = device_bridge::ChooseDevices(setting.arguments.texts("--device"), &scenario_);
    if (!chosen) return chosen;
    auto bridge = device_bridge::DeviceBridge::Create(scenario_, seed_, options);
    if (!bridge) return tl::unexpected(bridge.error());
    bridge_ = std::move(*bridge);
    auto heads = device_bridge::MakeHeads(scenario_.users, seed_);
    if (!heads) return tl::unexpected(heads.error());
    heads_ = std::move(*heads);
    auto tactiles = device_bridge::Tactiles::Create(scenario_);
    if (!tactiles) return tl::unexpected(tactiles.error());
    tactiles_ = std::move(*tactiles);
    return {};
  }
  core::Result<void> Connect(bus::Node* node, const bus::NodeOptions& /*options*/) override {
    std::vector<std::string> viewers;
    std::stringstream names(setting_->arguments.text("--viewers"));
    if (setting_->arguments.text("--hand") == "pointer") {
      for (std::string name; std::getline(names, name, ',') && viewers.size() < device_bridge::kMaxViewers;) {
        viewers.push_back(name);
      }
    }
    loop_.emplace(scenario_, std::move(heads_), std::move(tactiles_), bridge_.get(), node, std::move(viewers));
    loop_->Declare();
    return {};
  }
  void OnStart() override {
    for (std::size_t role = 0; role < scenario_.devices.size(); ++role) {
      const scene::Device& device = scenario_.devices[role];
      std::printf("role %s: %s %s\n", device.role.c_str(), device.type.c_str(), device.address.c_str());
    }
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed_));
  }
  void Run(const std::atomic<bool>& stop) override { loop_->Run(stop); }
  core::Result<void> WriteReport(bool is_realtime) override { return loop_->WriteReport(setting_->out, is_realtime); }

 private:
  const run_node::Setting* setting_ = nullptr;
  scene::Scenario scenario_;  // with the devices of the command line
  std::uint64_t seed_ = 0;
  std::unique_ptr<device_bridge::DeviceBridge> bridge_;
  std::vector<std::unique_ptr<device_bridge::HeadTracker>> heads_;  // until the loop has them
  std::unique_ptr<device_bridge::Tactiles> tactiles_;               // until the loop has them
  std::optional<device_bridge::NodeLoop> loop_;
};

}  // namespace

int main(int argc, char** argv) {
  run_node::Program program;
  program.name = "device_bridge";
  program.summary = "the devices of the operators' hands, real or simulated, behind the safety filter; 1 kHz";
  program.options = {{"--seed", "N", "of the simulated operator; default: the scenario's", "",
                      cli::Count(0, std::numeric_limits<std::uint64_t>::max())},
                     {"--hand", "script|pointer",
                      "who moves simulated arms: the scenario's script, or a person by mouse, keyboard or gamepad",
                      "script", cli::OneOf("script|pointer")},
                     {"--viewers", "NAME,NAME", "with --hand pointer: viewers by which the person may steer",
                      "visual_node,client-page"},
                     {"--device", "ROLE=TYPE:ADDRESS", "another device for a role, as right=udp:7460; repeatable"}};
  program.thread = "device-rt";
  // Above the haptic node: a sample or a write takes some microseconds and starts or closes the loop.
  program.fifo_priority = 85;
  program.can_record_steps = false;
  program.ready = "devices are open";
  return run_node::RunNode(argc, argv, program, std::make_unique<DeviceBridgeBody>());
}
