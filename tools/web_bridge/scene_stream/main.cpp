#include <unistd.h>

#include <atomic>
#include <csignal>

#include "nodes/run_node/command_line.hpp"
#include "nodes/visual_node/sky/earth_air.hpp"
#include "tools/web_bridge/scene_stream/live.hpp"
#include "tools/web_bridge/scene_stream/recording.hpp"
#include "tools/web_bridge/scene_stream/still.hpp"

// No RunNode: a viewer has no step.

namespace {

std::atomic<int> interrupted{0};
static_assert(std::atomic<int>::is_always_lock_free, "set from a signal handler");

void OnSignal(int number) {
  interrupted.store(number);
}

cli::Syntax Syntax() {
  cli::Syntax syntax;
  syntax.program = "scene_stream";
  syntax.summary =
      "writes the scene of a session, of a recording, or of a scenario as it begins, for the page; started by "
      "bridge.mjs";
  syntax.options = {
      {"--scenario", "FILE", "what is shown"},
      {"--recording", "FILE.mcap", "show this; with neither this nor --registry: the scenario as it begins"},
      {"--name", "NAME", "on the bus", "visual_node-web"}};
  for (const cli::Option& option : run_node::BusOptions()) syntax.options.push_back(option);
  return syntax;
}

core::Result<void> CheckOptions(const cli::Arguments& arguments) {
  const auto fail = [](const char* what) { return core::Fail(core::ErrorCode::kInvalidInput, what); };
  if (!arguments.has("--scenario")) return fail("--scenario FILE is missing");
  if (arguments.has("--recording")) return {};
  if (!arguments.has("--registry")) return {};
  if (arguments.has("--keys") == arguments.has("--no_encryption")) {
    return fail("either --keys DIR or --no_encryption must be given");
  }
  return {};
}

core::Result<void> Run(const cli::Arguments& arguments, const scene::Scenario& scenario) {
  const auto air = visual_node::CachedAir();
  scene_stream::Stream stream(scenario, STDOUT_FILENO, air ? *air : space::AirFromSpace::Vacuum());
  scene_stream::CommandLines commands(STDIN_FILENO);
  if (arguments.has("--recording")) {
    return scene_stream::StreamRecording(arguments.text("--recording"), scenario, &stream, &commands, interrupted);
  }
  if (!arguments.has("--registry")) return scene_stream::StreamStill(scenario, &stream, &commands, interrupted);
  const bus::NodeOptions options = run_node::MakeNodeOptions(arguments.text("--name"), arguments);
  return scene_stream::Live(scenario, &stream, &commands).Run(options, interrupted);
}

}  // namespace

int main(int argc, char** argv) {
  const cli::Syntax syntax = Syntax();
  int status = run_node::kDone;
  const auto arguments = run_node::ReadCommandLine(argc, argv, syntax, &status);
  if (!arguments) return status;
  if (const auto good = CheckOptions(*arguments); !good) {
    return run_node::Report(syntax.program, good.error().detail, run_node::kBadUsage);
  }
  const auto scenario = run_node::ReadScenario(syntax.program, arguments->text("--scenario"));
  if (!scenario) return run_node::kBadUsage;
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
  std::signal(SIGPIPE, SIG_IGN);
  const auto done = Run(*arguments, *scenario);
  return done ? run_node::kDone : run_node::Report(syntax.program, done.error().detail, run_node::kFailed);
}
