#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "bus/bulk/bulk_folder.hpp"
#include "nodes/logic_node/node_loop.hpp"
#include "nodes/run_node/command_line.hpp"
#include "nodes/run_node/run_node.hpp"
#include "replay/field_list.hpp"

namespace {

constexpr const char* kName = "logic_node";
constexpr const char* kCheckpoint = "logic_node.checkpoint";

class LogicBody final : public run_node::Body {
 public:
  core::Result<void> Build(const run_node::Setting& setting) override {
    setting_ = &setting;
    scenario_ = setting.scenario;
    if (setting.arguments.has("--stall_limit_s")) {
      scenario_.stall_limit_s = setting.arguments.checked_number("--stall_limit_s");
    }
    auto logic = logic_node::LogicNode::Create(scenario_);
    if (!logic) return tl::unexpected(logic.error());
    logic_ = std::move(*logic);
    return {};
  }
  core::Result<void> Connect(bus::Node* node, const bus::NodeOptions& options) override {
    loop_.emplace(scenario_, logic_.get(), node);
    loop_->Declare();
    const double patience_s = setting_->arguments.checked_number("--patience_s");
    loop_->WaitForLostNodes(static_cast<std::int64_t>(patience_s * 1e9));
    if (auto resumed = Resume(); !resumed) return resumed;
    auto bulk = bus::BulkServer::Create(node, options);
    if (!bulk) return tl::unexpected(bulk.error());
    bulk_ = std::move(*bulk);
    return {};
  }
  core::Result<run_node::StepFormat> DescribeSteps() override {
    return run_node::StepFormat{replay::DescribeFields<logic_node::Step>(), {}, {}};
  }
  void RecordSteps(bus::log::StepSink* sink) override { loop_->RecordSteps(sink); }
  void OnStart() override {
    // For viewers on machines that do not have it. The run does not depend on them.
    if (const auto offered = bus::OfferFolder(setting_->scenario.folder, "scenario", bulk_.get()); !offered) {
      run_node::Report(kName, "the scenario is not offered to others: " + offered.error().detail, run_node::kDone);
    }
  }
  void Run(const std::atomic<bool>& stop) override { loop_->Run(stop, report()); }
  core::Result<void> WriteReport(bool /*is_realtime*/) override {
    return run_node::CheckWritten(loop_->WriteReport(report()), setting_->out);
  }

 private:
  [[nodiscard]] std::filesystem::path report() const { return setting_->out / "logic_node.json"; }

  // From what an earlier life left in the folder of --resume; with that option there are checkpoints for a later one.
  core::Result<void> Resume() {
    if (!setting_->arguments.has("--resume")) return {};
    const auto left = std::filesystem::path(setting_->arguments.text("--resume")) / kCheckpoint;
    if (std::filesystem::exists(left)) {
      if (auto resumed = loop_->Resume(left); !resumed) return resumed;
      const core::LogicStatus& status = logic_->status();
      std::printf("goes on in step %s at %.3f s\n", status.step.c_str(), static_cast<double>(status.time_ns) * 1e-9);
    }
    loop_->KeepCheckpoints(setting_->out / kCheckpoint);
    return {};
  }

  const run_node::Setting* setting_ = nullptr;
  scene::Scenario scenario_;  // with the limit of the command line
  std::unique_ptr<logic_node::LogicNode> logic_;
  std::optional<logic_node::NodeLoop> loop_;
  std::unique_ptr<bus::BulkServer> bulk_;
};

}  // namespace

int main(int argc, char** argv) {
  run_node::Program program;
  program.name = kName;
  program.summary = "the procedure of the scenario: steps, conditions, parameters; 100 Hz";
  // By default no more than a busy computer may hold a node up.
  program.options = {
      {"--stall_limit_s", "S", "in a step before the procedure fails; default: the scenario's", "",
       cli::Number(1.0, 1e6)},
      {"--patience_s", "S", "for a node that was lost to come back before the procedure fails", "3",
       cli::Number(0.0, 3600.0)},
      {"--resume", "DIR", "goes on from the checkpoint that an earlier life left there, if it left one"}};
  program.ready = "procedure loaded, waiting for physics_node";
  return run_node::RunNode(argc, argv, program, std::make_unique<LogicBody>());
}
