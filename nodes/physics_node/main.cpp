// physics_node --scenario FILE --registry ENDPOINT --session N --out DIR [--name physics_node] [--rt try|off|enforce]
//   --keys DIR | --no_encryption  keys of the run, bus/keys.hpp
//   [--workers 1] [--method paper|fast] [--cache DIR]  for the pairs that it computes itself
//   [--checkpoint_period_s 0.1]  0: none; they are written to DIR/physics_node.checkpoint
//   [--steps FILE]               every tick with all that it reads, for `oos replay`
//   [--checkpoint FILE]          goes on from there, instead of the scenario's beginning
//   [--resume DIR]               the same, from the checkpoint that an earlier life left in DIR, if it left one
//   [--bind ADDRESS]             of this machine, where the others reach it

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

#include "bus/log/node_recording.hpp"
#include "bus/node_arguments.hpp"
#include "bus/rt/thread_setup.hpp"
#include "bus/rt/worker_pool.hpp"
#include "nodes/physics_node/node_loop.hpp"
#include "nodes/physics_node/sheet_thread.hpp"
#include "replay/field_list.hpp"
#include "replay/open_step_log.hpp"
#include "replay/platform.hpp"
#include "scene/load_scenario.hpp"

namespace {

constexpr int kSheetPriority = 60;  // below the world, which does not wait for it
constexpr int kPriority = 75;       // below haptic_node, which gives the beat

std::atomic<bool> stop{false};
void OnSignal(int) {
  stop.store(true);
}

int Complain(const std::string& what, int status) {
  std::fprintf(stderr, "physics_node: %s\n", what.c_str());
  return status;
}

core::Result<std::unique_ptr<bus::log::StepLog>> OpenSteps(const std::string& file, const scene::Scenario& scenario,
                                                           const physics_node::PhysicsNode& physics) {
  std::vector<std::uint8_t> checkpoint;
  if (physics.tick() > 0) {
    physics_node::Snapshot snapshot;
    physics.Save(&snapshot);
    auto encoded = physics_node::EncodeSnapshot(physics.content_digest(), snapshot);
    if (!encoded) return tl::unexpected(encoded.error());
    checkpoint = std::move(*encoded);
  }
  bus::log::TextMap about = replay::DescribeRun(scenario);
  about["denormals"] = "flushed";  // by SetUpThread
  about["content"] = std::to_string(physics.content_digest());
  return replay::OpenStepLog(file, "physics_node", replay::DescribeFields<physics_node::Step>(), about, checkpoint);
}

}  // namespace

int main(int argc, char** argv) {
  const bus::NodeArguments defaults = {
      {"--rt", "try"}, {"--name", "physics_node"},       {"--workers", "1"},   {"--method", ""},
      {"--cache", ""}, {"--checkpoint_period_s", "0.1"}, {"--checkpoint", ""}, {"--steps", ""},
  };
  auto parsed = bus::ParseNodeArguments(argc, argv, defaults);
  if (!parsed) return Complain(parsed.error().detail, 2);
  bus::NodeArguments& options = *parsed;
  bus::RealTimeMode mode{};
  if (!bus::ParseRealTimeMode(options["--rt"], &mode)) return Complain("--rt is off, try or enforce", 2);
  const long workers = std::strtol(options["--workers"].c_str(), nullptr, 10);
  if (workers < 1 || workers > 64) return Complain("--workers is from 1 to 64", 2);
  if (options.count("--resume") != 0) {
    const auto left = std::filesystem::path(options["--resume"]) / "physics_node.checkpoint";
    if (std::filesystem::exists(left)) options["--checkpoint"] = left.string();
  }
  const double period_s = std::strtod(options["--checkpoint_period_s"].c_str(), nullptr);
  if (!(period_s >= 0.0 && period_s <= 3600.0)) return Complain("--checkpoint_period_s is from 0 to 3600", 2);
  std::signal(SIGTERM, OnSignal);
  std::signal(SIGINT, OnSignal);

  auto scenario = scene::LoadScenario(options["--scenario"]);
  if (!scenario) {
    for (const scene::Diagnostic& diagnostic : scenario.error()) Complain(scene::Format(diagnostic), 2);
    return 2;
  }
  if (!options["--method"].empty()) scenario->method = options["--method"];
  bus::WorkerPool pool(static_cast<unsigned>(workers), "physics-work", mode == bus::RealTimeMode::kOff ? 0 : kPriority);
  physics_node::Options physics_options;
  physics_options.workers = &pool;
  physics_options.collision.cache = options["--cache"];
  physics_options.collision.progress = [](const std::string& line) {
    std::printf("%s\n", line.c_str());
    std::fflush(stdout);
  };
  std::optional<physics_node::SheetThread> sheet_thread;  // outlives the node that it works for
  auto physics = physics_node::PhysicsNode::Create(*scenario, physics_options);
  if (!physics) return Complain(physics.error().detail, 1);
  if ((*physics)->sheets().num_sheets() > 0) {
    sheet_thread.emplace(mode, kSheetPriority);
    (*physics)->sheets().set_runner(&*sheet_thread);
  }
  physics_node::Snapshot snapshot;
  if (!options["--checkpoint"].empty()) {
    auto restored = physics_node::ReadSnapshot(options["--checkpoint"], (*physics)->content_digest(), &snapshot);
    if (restored) restored = (*physics)->Restore(&snapshot);
    if (!restored) return Complain(restored.error().detail, 1);
  }

  const bus::NodeOptions node_options = bus::MakeNodeOptions(options["--name"], options);
  auto recording = bus::log::StartRecording(node_options.name, options, {{"platform", replay::DescribePlatform()}});
  if (!recording) return Complain(recording.error().detail, 1);
  auto node = bus::Node::Create(bus::log::WithTap(node_options, recording->get()));
  if (!node) return Complain(node.error().detail, 1);
  physics_node::NodeLoop loop(*scenario, physics->get(), node->get());
  loop.Declare();
  if (!options["--checkpoint"].empty()) {
    loop.Restore(&snapshot);
    std::printf("goes on from tick %llu\n", static_cast<unsigned long long>(snapshot.tick));
  }
  if (period_s > 0.0) {
    loop.KeepCheckpoints(std::filesystem::path(options["--out"]) / "physics_node.checkpoint",
                         static_cast<std::int64_t>(period_s * 1e9));
  }
  std::unique_ptr<bus::log::StepLog> steps;
  if (!options["--steps"].empty()) {
    auto opened = OpenSteps(options["--steps"], *scenario, **physics);
    if (!opened) return Complain(opened.error().detail, 1);
    steps = std::move(*opened);
    loop.RecordSteps(steps.get());
  }
  if (const auto started = (*node)->Start(); !started) return Complain(started.error().detail, 1);

  bus::ThreadSetup setup;
  setup.name = "physics-rt";
  setup.mode = mode;
  setup.fifo_priority = kPriority;
  const bus::ThreadReport thread = bus::SetUpThread(setup);
  std::printf("%s\nready\n", thread.text.c_str());
  std::fflush(stdout);
  if (!thread.is_ok) return 1;
  (*node)->Emit({0, node_options.name, "ready", "masses known, loop starts"});
  loop.Run(stop);
  if (const auto stopped = bus::log::StopRecording(recording->get()); !stopped)
    return Complain(stopped.error().detail, 1);
  if (steps != nullptr) {
    if (const auto closed = steps->Close(); !closed) return Complain(closed.error().detail, 1);
    std::printf("steps that were not recorded: %llu\n", static_cast<unsigned long long>(steps->num_lost()));
  }
  if (!loop.WriteReport(std::filesystem::path(options["--out"]) / "physics_node.json", thread.is_fifo)) {
    return Complain("cannot write its report to " + options["--out"], 1);
  }
  return 0;
}
