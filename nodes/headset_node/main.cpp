#include <csignal>
#include <cstdlib>

#include "nodes/headset_node/headset_node.hpp"
#include "nodes/run_node/command_line.hpp"

// No RunNode: the headset has the loop. Command line, scenario and exit status are those of every node.

namespace {

volatile std::sig_atomic_t is_stop_wanted = 0;

void Stop(int /*signal*/) {
  is_stop_wanted = 1;
}

cli::Syntax CommandLineSyntax() {
  cli::Syntax syntax;
  syntax.program = "headset_node";
  syntax.summary = "shows the scenario in a headset as it runs (OpenXR)";
  syntax.options = {{"--scenario", "FILE", "what is shown", "", {}, true},
                    {"--out", "DIR", "of the latency table", "."},
                    {"--name", "NAME", "on the bus", "visual_node-headset"},
                    {"--view", "NAME", "the camera where the head is at first; default: that of the step"},
                    {"--show", "LIST", "what is shown over the scene, as of 'oos view'"}};
  for (const cli::Option& option : run_node::BusOptions()) syntax.options.push_back(option);
  syntax.details = "Needs the OpenXR runtime of the headset's maker. Without a headset: nodes/headset_node/README.md.";
  return syntax;
}

}  // namespace

int main(int argc, char** argv) {
  const cli::Syntax syntax = CommandLineSyntax();
  int status = run_node::kDone;
  const auto arguments = run_node::ReadCommandLine(argc, argv, syntax, &status);
  if (!arguments) return status;
  headset_node::Options options;
  options.scenario = arguments->text("--scenario");
  options.node = run_node::MakeNodeOptions(arguments->text("--name"), *arguments);
  options.out = arguments->text("--out");
  options.view = arguments->text("--view");
  options.show = arguments->text("--show");
  const auto scenario = run_node::ReadScenario(syntax.program, options.scenario);
  if (!scenario) return run_node::kBadUsage;
  setenv("LP_NUM_THREADS", "1", 0);  // as visual_node's
  std::signal(SIGTERM, Stop);
  std::signal(SIGINT, Stop);
  const auto done = headset_node::RunHeadset(options, *scenario, is_stop_wanted);
  if (done) return run_node::kDone;
  const bool is_input_bad = done.error().code == core::ErrorCode::kInvalidInput;
  return run_node::Report(syntax.program, done.error().detail, is_input_bad ? run_node::kBadUsage : run_node::kFailed);
}
