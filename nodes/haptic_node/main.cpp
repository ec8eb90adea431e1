#include <cstdio>
#include <memory>
#include <optional>

#include "bus/rt/worker_pool.hpp"
#include "nodes/haptic_node/node_loop.hpp"
#include "nodes/run_node/run_node.hpp"
#include "replay/field_list.hpp"

namespace {

constexpr int kPriority = 80;
// Collision may take this much of a cycle; then the pairs with the oldest results go first in the next.
constexpr std::int64_t kBudget_ns = 700'000;

class HapticBody final : public run_node::Body {
 public:
  core::Result<void> Build(const run_node::Setting& setting) override {
    setting_ = &setting;
    pool_.emplace(static_cast<unsigned>(setting.arguments.checked_count("--workers")), "haptic-work",
                  setting.mode == bus::RealTimeMode::kOff ? 0 : kPriority);
    haptic_node::Options options;
    options.collision.cache = setting.arguments.text("--cache");
    options.collision.progress = run_node::PrintLine;
    options.budget_ns = kBudget_ns;
    auto haptic = haptic_node::HapticNode::Create(setting.scenario, *pool_, options);
    if (!haptic) return tl::unexpected(haptic.error());
    haptic_ = std::move(*haptic);
    return {};
  }
  core::Result<void> Connect(bus::Node* node, const bus::NodeOptions& /*options*/) override {
    loop_.emplace(setting_->scenario, haptic_.get(), node);
    loop_->Declare();
    return {};
  }
  core::Result<run_node::StepFormat> DescribeSteps() override {
    return run_node::StepFormat{replay::DescribeFields<haptic_node::Step>(), {}, {}};
  }
  void RecordSteps(bus::log::StepSink* sink) override { loop_->RecordSteps(sink); }
  void Run(const std::atomic<bool>& stop) override { loop_->Run(stop); }
  core::Result<void> WriteReport(bool is_realtime) override {
    return run_node::CheckWritten(loop_->WriteReport(setting_->out / "haptic_node.json", is_realtime), setting_->out);
  }

 private:
  const run_node::Setting* setting_ = nullptr;
  std::optional<bus::WorkerPool> pool_;
  std::unique_ptr<haptic_node::HapticNode> haptic_;
  std::optional<haptic_node::NodeLoop> loop_;
};

}  // namespace

int main(int argc, char** argv) {
  run_node::Program program;
  program.name = "haptic_node";
  program.summary = "the forces of the operators' hands; 1 kHz";
  program.options = {run_node::WorkersOption(),
                     run_node::MethodOption(),
                     {"--coupling", "paper|god_object", "how the hand follows the device; default: the scenario's"},
                     run_node::CacheOption()};
  program.thread = "haptic-rt";
  program.fifo_priority = kPriority;
  program.ready = "structures cooked, loop starts";
  return run_node::RunNode(argc, argv, program, std::make_unique<HapticBody>());
}
