// logic_node --scenario FILE --registry ENDPOINT --session N --out DIR [--steps FILE] [--bind ADDRESS]
//   --keys DIR | --no_encryption  keys of the run, bus/keys.hpp
//   [--resume DIR]       goes on from the checkpoint that an earlier life left in DIR, if it left one
//   [--patience_s 3]     how long a node that was lost may take to come back before the procedure fails: by default no
//                        more than a busy computer may hold one up

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "bus/bulk_folder.hpp"
#include "bus/log/node_recording.hpp"
#include "bus/node_arguments.hpp"
#include "nodes/logic_node/node_loop.hpp"
#include "replay/field_list.hpp"
#include "replay/open_step_log.hpp"
#include "replay/platform.hpp"
#include "scene/load_scenario.hpp"

namespace {

std::atomic<bool> stop{false};
void OnSignal(int) {
  stop.store(true);
}

int Complain(const std::string& what, int status) {
  std::fprintf(stderr, "logic_node: %s\n", what.c_str());
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  auto parsed = bus::ParseNodeArguments(argc, argv, {{"--patience_s", "3"}});
  if (!parsed) return Complain(parsed.error().detail, 2);
  bus::NodeArguments& options = *parsed;
  const double patience_s = std::strtod(options["--patience_s"].c_str(), nullptr);
  if (!(patience_s >= 0.0 && patience_s <= 3600.0)) return Complain("--patience_s is from 0 to 3600", 2);
  std::signal(SIGTERM, OnSignal);
  std::signal(SIGINT, OnSignal);

  const auto scenario = scene::LoadScenario(options["--scenario"]);
  if (!scenario) {
    for (const scene::Diagnostic& diagnostic : scenario.error()) Complain(scene::Format(diagnostic), 2);
    return 2;
  }
  auto logic = logic_node::LogicNode::Create(*scenario);
  if (!logic) return Complain(logic.error().detail, 2);

  const bus::NodeOptions node_options = bus::MakeNodeOptions("logic_node", options);
  auto recording = bus::log::StartRecording(node_options.name, options, {{"platform", replay::DescribePlatform()}});
  if (!recording) return Complain(recording.error().detail, 1);
  auto node = bus::Node::Create(bus::log::WithTap(node_options, recording->get()));
  if (!node) return Complain(node.error().detail, 1);
  logic_node::NodeLoop loop(*scenario, logic->get(), node->get());
  loop.Declare();
  loop.WaitForLostNodes(static_cast<std::int64_t>(patience_s * 1e9));
  const auto checkpoint = std::filesystem::path(options["--out"]) / "logic_node.checkpoint";
  if (options.count("--resume") != 0) {
    const auto left = std::filesystem::path(options["--resume"]) / "logic_node.checkpoint";
    if (std::filesystem::exists(left)) {
      if (const auto resumed = loop.Resume(left); !resumed) return Complain(resumed.error().detail, 1);
      const core::LogicStatus& status = (*logic)->status();
      std::printf("goes on in step %s at %.3f s\n", status.step.c_str(), static_cast<double>(status.time_ns) * 1e-9);
    }
    loop.KeepCheckpoints(checkpoint);
  }
  auto bulk = bus::BulkServer::Create(node->get(), node_options);
  if (!bulk) return Complain(bulk.error().detail, 1);
  std::unique_ptr<bus::log::StepLog> steps;
  if (!options["--steps"].empty()) {
    bus::log::TextMap about = replay::DescribeRun(*scenario);
    auto opened =
        replay::OpenStepLog(options["--steps"], "logic_node", replay::DescribeFields<logic_node::Step>(), about, {});
    if (!opened) return Complain(opened.error().detail, 1);
    steps = std::move(*opened);
    loop.RecordSteps(steps.get());
  }
  if (const auto started = (*node)->Start(); !started) return Complain(started.error().detail, 1);

  // For viewers on machines that do not have it. The run does not depend on them.
  if (const auto offered = bus::OfferFolder(scenario->folder, "scenario", bulk->get()); !offered) {
    Complain("the scenario is not offered to others: " + offered.error().detail, 0);
  }
  std::printf("ready\n");
  std::fflush(stdout);
  (*node)->Emit({0, "logic_node", "ready", "procedure loaded, waiting for physics_node"});
  const std::filesystem::path report = std::filesystem::path(options["--out"]) / "logic_node.json";
  loop.Run(stop, report);
  if (const auto stopped = bus::log::StopRecording(recording->get()); !stopped)
    return Complain(stopped.error().detail, 1);
  if (steps != nullptr) {
    if (const auto closed = steps->Close(); !closed) return Complain(closed.error().detail, 1);
    std::printf("steps that were not recorded: %llu\n", static_cast<unsigned long long>(steps->num_lost()));
  }
  if (!loop.WriteReport(report)) return Complain("cannot write its report to " + options["--out"], 1);
  return 0;
}
