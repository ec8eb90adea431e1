#include "nodes/haptic_node/program.hpp"

#include "replay/field_list.hpp"

namespace haptic_node {
namespace {

constexpr int kPriority = 80;
// Collision may take this much of a cycle; then the pairs with the oldest results go first in the next.
constexpr std::int64_t kBudget_ns = 700'000;

}  // namespace

run_node::Program MakeProgram() {
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
  return program;
}

core::Result<void> Body::Build(const run_node::Setting& setting) {
  setting_ = &setting;
  pool_.emplace(static_cast<unsigned>(setting.arguments.checked_count("--workers")), "haptic-work",
                setting.mode == bus::RealTimeMode::kOff ? 0 : kPriority);
  Options options;
  options.collision.cache = setting.arguments.text("--cache");
  options.collision.progress = run_node::PrintLine;
  options.budget_ns = kBudget_ns;
  auto haptic = HapticNode::Create(setting.scenario, *pool_, options);
  if (!haptic) return tl::unexpected(haptic.error());
  haptic_ = std::move(*haptic);
  return {};
}

core::Result<void> Body::Connect(bus::Node* node, const bus::NodeOptions& /*options*/) {
  loop_.emplace(setting_->scenario, haptic_.get(), node, answer_);
  loop_->Declare();
  return {};
}

core::Result<run_node::StepFormat> Body::DescribeSteps() {
  return run_node::StepFormat{replay::DescribeFields<Step>(), {}, {}};
}

core::Result<void> Body::WriteReport(bool is_realtime) {
  return run_node::CheckWritten(loop_->WriteReport(setting_->out / "haptic_node.json", is_realtime), setting_->out);
}

}  // namespace haptic_node
