#include "nodes/visual_node/options.hpp"

#include <algorithm>

#include "nodes/run_node/command_line.hpp"

namespace visual_node {
namespace {

constexpr int kLeastSize = 64, kMostSize = 8192;  // pixels

// "640x360"
core::Result<void> ReadSize(const std::string& text, Options* options) {
  const std::size_t x = std::min(text.find('x'), text.size());
  const auto width = cli::ReadCount(text.substr(0, x));
  const auto height = cli::ReadCount(text.substr(std::min(x + 1, text.size())));
  const auto is_good = [](const auto& pixels) { return pixels && *pixels >= kLeastSize && *pixels <= kMostSize; };
  if (!is_good(width) || !is_good(height)) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "--size needs WIDTHxHEIGHT, each from 64 to 8192, not '" + text + "'");
  }
  options->width = options->window_width = static_cast<int>(*width);
  options->height = options->window_height = static_cast<int>(*height);
  return {};
}

}  // namespace

cli::Syntax CommandLineSyntax() {
  cli::Syntax syntax;
  syntax.program = "visual_node";
  syntax.summary = "shows the scenario as it runs";
  syntax.options = {{"--scenario", "FILE", "what is shown"},
                    {"--out", "DIR", "of pictures and the report", "."},
                    {"--still", "FILE", "each named camera of this scenario once, to DIR; without a bus"},
                    {"--name", "NAME", "on the bus", "visual_node"},
                    {"--size", "WIDTHxHEIGHT", "of the window and of pictures; default: 1280x720 and 640x360"},
                    {"--view", "NAME", "camera to stay with; default: the one named after the step, else the first"},
                    {"--headless", "", "renders pictures but shows no window"},
                    {"--fps", "N", "most pictures per second; a slow machine draws them smaller to hold it", "30",
                     cli::Number(1.0, 1000.0)}};
  for (const cli::Option& option : run_node::BusOptions()) syntax.options.push_back(option);
  syntax.details = "'oos run' and 'oos launch' start the nodes of a run; 'oos view' starts another viewer of a run.";
  return syntax;
}

core::Result<Options> ReadOptions(const cli::Arguments& arguments) {
  Options options;
  options.is_still = arguments.has("--still");
  options.scenario = arguments.text(options.is_still ? "--still" : "--scenario");
  options.node = run_node::MakeNodeOptions(arguments.text("--name"), arguments);
  options.out = arguments.text("--out");
  options.recording = run_node::MakeRecordingOptions(arguments);
  options.recording.scenario.clear();  // the other nodes' recordings have it
  options.view = arguments.text("--view");
  options.is_headless = arguments.has("--headless");
  options.max_frames_per_s = arguments.checked_number("--fps");
  if (arguments.has("--size")) {
    if (auto read = ReadSize(arguments.text("--size"), &options); !read) return tl::unexpected(read.error());
  }
  const auto fail = [](const char* what) { return core::Fail(core::ErrorCode::kInvalidInput, what); };
  if (options.is_still) return options;
  if (options.scenario.empty()) return fail("--scenario FILE is missing");
  if (options.node.registry.empty()) return fail("--registry ENDPOINT is missing");
  if (options.node.is_encrypted == options.node.keys.empty()) {
    return fail("either --keys DIR or --no_encryption must be given");
  }
  return options;
}

}  // namespace visual_node
