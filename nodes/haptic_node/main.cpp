// haptic_node --scenario FILE --registry ENDPOINT --session N --out DIR [--workers 1] [--rt try|off|enforce]
//   --keys DIR | --no_encryption  keys of the run, bus/keys.hpp
//   [--steps FILE]  every cycle with all that it reads, for `oos replay`
//   [--cache DIR] [--bind ADDRESS]  of this machine, where the others reach it

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "bus/log/node_recording.hpp"
#include "bus/node_arguments.hpp"
#include "bus/rt/thread_setup.hpp"
#include "bus/rt/worker_pool.hpp"
#include "nodes/haptic_node/node_loop.hpp"
#include "replay/field_list.hpp"
#include "replay/open_step_log.hpp"
#include "replay/platform.hpp"
#include "scene/load_scenario.hpp"

namespace {

constexpr int kPriority = 80;
// Collision may take this much of a cycle; then the pairs with the oldest results go first in the next.
constexpr std::int64_t kBudget_ns = 700'000;

std::atomic<bool> stop{false};
void OnSignal(int) {
  stop.store(true);
}

int Complain(const std::string& what, int status) {
  std::fprintf(stderr, "haptic_node: %s\n", what.c_str());
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  const bus::NodeArguments defaults = {
      {"--workers", "1"}, {"--rt", "try"}, {"--cache", ""}, {"--method", ""}, {"--steps", ""}};
  auto parsed = bus::ParseNodeArguments(argc, argv, defaults);
  if (!parsed) return Complain(parsed.error().detail, 2);
  bus::NodeArguments& options = *parsed;
  bus::RealTimeMode mode{};
  if (!bus::ParseRealTimeMode(options["--rt"], &mode)) return Complain("--rt is off, try or enforce", 2);
  const long workers = std::strtol(options["--workers"].c_str(), nullptr, 10);
  if (workers < 1 || workers > 64) return Complain("--workers is from 1 to 64", 2);
  std::signal(SIGTERM, OnSignal);
  std::signal(SIGINT, OnSignal);

  auto scenario = scene::LoadScenario(options["--scenario"]);
  if (!scenario) {
    for (const scene::Diagnostic& diagnostic : scenario.error()) Complain(scene::Format(diagnostic), 2);
    return 2;
  }
  if (!options["--method"].empty()) scenario->method = options["--method"];
  bus::WorkerPool pool(static_cast<unsigned>(workers), "haptic-work", mode == bus::RealTimeMode::kOff ? 0 : kPriority);
  haptic_node::Options haptic_options;
  haptic_options.collision.cache = options["--cache"];
  haptic_options.budget_ns = kBudget_ns;
  haptic_options.collision.progress = [](const std::string& line) {
    std::printf("%s\n", line.c_str());
    std::fflush(stdout);
  };
  auto haptic = haptic_node::HapticNode::Create(*scenario, pool, haptic_options);
  if (!haptic) return Complain(haptic.error().detail, 1);

  const bus::NodeOptions node_options = bus::MakeNodeOptions("haptic_node", options);
  auto recording = bus::log::StartRecording(node_options.name, options, {{"platform", replay::DescribePlatform()}});
  if (!recording) return Complain(recording.error().detail, 1);
  auto node = bus::Node::Create(bus::log::WithTap(node_options, recording->get()));
  if (!node) return Complain(node.error().detail, 1);
  haptic_node::NodeLoop loop(*scenario, haptic->get(), node->get());
  loop.Declare();
  std::unique_ptr<bus::log::StepLog> steps;
  if (!options["--steps"].empty()) {
    bus::log::TextMap about = replay::DescribeRun(*scenario);
    about["denormals"] = "flushed";  // by SetUpThread
    auto opened =
        replay::OpenStepLog(options["--steps"], "haptic_node", replay::DescribeFields<haptic_node::Step>(), about, {});
    if (!opened) return Complain(opened.error().detail, 1);
    steps = std::move(*opened);
    loop.RecordSteps(steps.get());
  }
  if (const auto started = (*node)->Start(); !started) return Complain(started.error().detail, 1);

  bus::ThreadSetup setup;
  setup.name = "haptic-rt";
  setup.mode = mode;
  setup.fifo_priority = kPriority;
  const bus::ThreadReport thread = bus::SetUpThread(setup);
  std::printf("%s\nready\n", thread.text.c_str());
  std::fflush(stdout);
  if (!thread.is_ok) return 1;
  (*node)->Emit({0, "haptic_node", "ready", "structures cooked, loop starts"});
  loop.Run(stop);
  if (const auto stopped = bus::log::StopRecording(recording->get()); !stopped)
    return Complain(stopped.error().detail, 1);
  if (steps != nullptr) {
    if (const auto closed = steps->Close(); !closed) return Complain(closed.error().detail, 1);
    std::printf("steps that were not recorded: %llu\n", static_cast<unsigned long long>(steps->num_lost()));
  }
  if (!loop.WriteReport(std::filesystem::path(options["--out"]) / "haptic_node.json", thread.is_fifo)) {
    return Complain("cannot write its report to " + options["--out"], 1);
  }
  return 0;
}
