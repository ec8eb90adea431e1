#include <csignal>
#include <cstdlib>

#include "nodes/run_node/command_line.hpp"
#include "nodes/visual_node/options.hpp"
#include "nodes/visual_node/still.hpp"
#include "nodes/visual_node/viewer.hpp"

// No RunNode: a viewer has no step, and the window's loop is its own. Command line, scenario and exit status are those
// of every node.

namespace {

visual_node::Signals signals;

void StopViewer(int /*signal*/) {
  signals.is_stop_wanted = 1;
}
void TakeScreenshot(int /*signal*/) {
  signals.is_screenshot_wanted = 1;
}

}  // namespace

int main(int argc, char** argv) {
  const cli::Syntax syntax = visual_node::CommandLineSyntax();
  int status = run_node::kDone;
  const auto arguments = run_node::ReadCommandLine(argc, argv, syntax, &status);
  if (!arguments) return status;
  const auto options = visual_node::ReadOptions(*arguments);
  if (!options) return run_node::Report(syntax.program, options.error().detail, run_node::kBadUsage);
  const auto scenario = run_node::ReadScenario(syntax.program, options->scenario);
  if (!scenario) return run_node::kBadUsage;
  // One drawing thread of the software renderer: the other core belongs to the force loop. Read before GL starts.
  setenv("LP_NUM_THREADS", "1", 0);
  std::signal(SIGTERM, StopViewer);
  std::signal(SIGINT, StopViewer);
  std::signal(SIGUSR1, TakeScreenshot);
  const auto done = options->is_still ? visual_node::RenderStills(*options, *scenario)
                                      : visual_node::RunViewer(*options, *scenario, signals);
  return done ? run_node::kDone : run_node::Report(syntax.program, done.error().detail, run_node::kFailed);
}
