#include "nodes/physics_node/program.hpp"

#include <cstdio>
#include <filesystem>

#include "replay/field_list.hpp"

namespace physics_node {
namespace {

constexpr int kSheetPriority = 60;  // below the world, which does not wait for it
constexpr int kPriority = 75;       // below haptic_node, which gives the beat
constexpr const char* kCheckpoint = "physics_node.checkpoint";

}  // namespace

run_node::Program MakeProgram() {
  run_node::Program program;
  program.name = "physics_node";
  program.summary = "the world: bodies, joints, sheets and their contacts; 1 kHz";
  program.options = {
      {"--name", "NAME", "on the bus", "physics_node"},
      run_node::WorkersOption(),
      run_node::MethodOption(),
      run_node::CacheOption(),
      {"--checkpoint_period_s", "S", "from one checkpoint in DIR to the next, 0: none", "0.1",
       cli::Number(0.0, 3600.0)},
      {"--checkpoint", "FILE", "goes on from there, instead of the scenario's beginning"},
      {"--resume", "DIR", "the same, from the checkpoint that an earlier life left there, if it left one"}};
  program.thread = "physics-rt";
  program.fifo_priority = kPriority;
  program.ready = "masses known, loop starts";
  return program;
}

core::Result<void> Body::Build(const run_node::Setting& setting) {
  setting_ = &setting;
  pool_.emplace(static_cast<unsigned>(setting.arguments.checked_count("--workers")), "physics-work",
                setting.mode == bus::RealTimeMode::kOff ? 0 : kPriority);
  Options options;
  options.workers = &*pool_;
  options.collision.cache = setting.arguments.text("--cache");
  options.collision.progress = run_node::PrintLine;
  auto physics = PhysicsNode::Create(setting.scenario, options);
  if (!physics) return tl::unexpected(physics.error());
  physics_ = std::move(*physics);
  if (physics_->sheets().num_sheets() > 0) {
    sheet_thread_.emplace(setting.mode, kSheetPriority);
    physics_->sheets().set_runner(&*sheet_thread_);
  }
  return Restore();
}

// From --checkpoint, or from what an earlier life left in the folder of --resume.
core::Result<void> Body::Restore() {
  std::filesystem::path file = setting_->arguments.text("--checkpoint");
  if (setting_->arguments.has("--resume")) {
    const auto left = std::filesystem::path(setting_->arguments.text("--resume")) / kCheckpoint;
    if (std::filesystem::exists(left)) file = left;
  }
  if (file.empty()) return {};
  is_restored_ = true;
  auto restored = ReadSnapshot(file, physics_->content_digest(), &snapshot_);
  return restored ? physics_->Restore(&snapshot_) : restored;
}

core::Result<void> Body::Connect(bus::Node* node, const bus::NodeOptions& /*options*/) {
  loop_.emplace(setting_->scenario, physics_.get(), node, cycle_);
  loop_->Declare();
  if (is_restored_) {
    loop_->Restore(&snapshot_);
    std::printf("goes on from tick %llu\n", static_cast<unsigned long long>(snapshot_.tick));
  }
  const double period_s = setting_->arguments.checked_number("--checkpoint_period_s");
  if (period_s > 0.0) loop_->KeepCheckpoints(setting_->out / kCheckpoint, static_cast<std::int64_t>(period_s * 1e9));
  return {};
}

core::Result<run_node::StepFormat> Body::DescribeSteps() {
  run_node::StepFormat format{replay::DescribeFields<Step>(), {}, {}};
  format.about["content"] = std::to_string(physics_->content_digest());
  if (physics_->tick() == 0) return format;
  Snapshot snapshot;
  physics_->Save(&snapshot);
  auto encoded = EncodeSnapshot(physics_->content_digest(), snapshot);
  if (!encoded) return tl::unexpected(encoded.error());
  format.checkpoint = std::move(*encoded);
  return format;
}

core::Result<void> Body::WriteReport(bool is_realtime) {
  return run_node::CheckWritten(loop_->WriteReport(setting_->out / "physics_node.json", is_realtime), setting_->out);
}

}  // namespace physics_node
