#include "nodes/visual_node/program.hpp"

#include <csignal>
#include <cstdlib>

#include "nodes/run_node/command_line.hpp"
#include "nodes/visual_node/force_loop.hpp"
#include "nodes/visual_node/options.hpp"
#include "nodes/visual_node/pictures/replay_frames.hpp"
#include "nodes/visual_node/pictures/shot.hpp"
#include "nodes/visual_node/pictures/still.hpp"
#include "nodes/visual_node/viewer.hpp"

namespace visual_node {
namespace {

Signals signals;

void StopViewer(int /*signal*/) {
  signals.is_stop_wanted = 1;
}
void TakeScreenshot(int /*signal*/) {
  signals.is_screenshot_wanted = 1;
}

int ReportEnd(const std::string& program, const core::Result<void>& done) {
  if (done) return run_node::kDone;
  const bool is_input_bad = done.error().code == core::ErrorCode::kInvalidInput;
  return run_node::Report(program, done.error().detail, is_input_bad ? run_node::kBadUsage : run_node::kFailed);
}

core::Result<void> MakePictures(const Options& options, const scene::Scenario& scenario) {
  if (options.is_still) return RenderStills(options, scenario);
  if (options.pictures.is_shot()) return RenderShot(options, scenario);
  return RenderFrames(options, scenario, [](const picture::Image& image) { return WritePpm(image, stdout); });
}

}  // namespace

int RunProgram(int argc, char** argv, const cli::Syntax& syntax, const MakeSurfaces& make_surfaces) {
  int status = run_node::kDone;
  const auto arguments = run_node::ReadCommandLine(argc, argv, syntax, &status);
  if (!arguments) return status;
  const auto options = ReadOptions(*arguments);
  if (!options) return run_node::Report(syntax.program, options.error().detail, run_node::kBadUsage);
  const auto scenario = run_node::ReadScenario(syntax.program, options->scenario);
  if (!scenario) return run_node::kBadUsage;
  if (options->is_still || options->pictures.is_shot() || options->pictures.are_frames) {
    return ReportEnd(syntax.program, MakePictures(*options, *scenario));
  }
  // One drawing thread of the software renderer beside a force loop, to which the other cores belong; all where there
  // is none, as at a replay. Launchers, which start both at once, set it themselves. Read when GL starts.
  if (HasForceLoop()) setenv("LP_NUM_THREADS", "1", 0);
  std::signal(SIGTERM, StopViewer);
  std::signal(SIGINT, StopViewer);
  std::signal(SIGUSR1, TakeScreenshot);
  core::Result<std::unique_ptr<Surfaces>> surfaces;
  if (make_surfaces) surfaces = make_surfaces(*arguments, *options);
  if (!surfaces) return ReportEnd(syntax.program, tl::unexpected(surfaces.error()));
  return ReportEnd(syntax.program, RunViewer(*options, *scenario, signals, surfaces->get()));
}

}  // namespace visual_node
