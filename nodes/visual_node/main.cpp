#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "nodes/visual_node/options.hpp"
#include "nodes/visual_node/still.hpp"
#include "nodes/visual_node/viewer.hpp"
#include "scene/load_scenario.hpp"

namespace {

visual_node::Signals signals;

void Stop(int) {
  signals.is_stop_wanted = 1;
}
void Screenshot(int) {
  signals.is_screenshot_wanted = 1;
}

}  // namespace

int main(int argc, char** argv) {
  const auto options = visual_node::ParseOptions(argc, argv);
  if (!options) {
    std::fprintf(stderr, "visual_node: %s\n%s", options.error().detail.c_str(), visual_node::kUsage);
    return 2;
  }
  const auto scenario = scene::LoadScenario(options->scenario);
  if (!scenario) {
    for (const scene::Diagnostic& diagnostic : scenario.error()) {
      std::fprintf(stderr, "%s\n", scene::Format(diagnostic).c_str());
    }
    return 2;
  }
  // One drawing thread of the software renderer: the other core belongs to the force loop. Read before GL starts.
  setenv("LP_NUM_THREADS", "1", 0);
  std::signal(SIGTERM, Stop);
  std::signal(SIGINT, Stop);
  std::signal(SIGUSR1, Screenshot);
  const auto done = options->is_still ? visual_node::RenderStills(*options, *scenario)
                                      : visual_node::RunViewer(*options, *scenario, signals);
  if (!done) {
    std::fprintf(stderr, "visual_node: %s\n", done.error().detail.c_str());
    return 1;
  }
  return 0;
}
