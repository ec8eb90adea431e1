#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "collision/resolution/choose_resolutions.hpp"
#include "core/names.hpp"
#include "nodes/lockstep/replay_steps.hpp"
#include "nodes/logic_node/procedure.hpp"
#include "replay/open_step_log.hpp"
#include "replay/platform.hpp"
#include "tools/oos/attach/attach.hpp"
#include "tools/oos/pictures/picture_source.hpp"
#include "tools/oos/pictures/video.hpp"
#include "tools/oos/replay/replay_bus.hpp"
#include "tools/oos/replay/verbs.hpp"
#include "vps/asset/cooked_object.hpp"

namespace oos {
namespace {

std::string TextOrUnknown(const bus::log::TextMap& map, const char* key) {
  const auto found = map.find(key);
  return found == map.end() ? "unknown" : found->second;
}

// The scenario of --scenario, else the one that the recording names, relative to here or to the recording.
core::Result<scene::Scenario> FindScenario(const Arguments& arguments, const std::filesystem::path& file,
                                           const lockstep::RecordedNode& recorded) {
  std::filesystem::path path = arguments.text("--scenario", TextOrUnknown(recorded.about, "scenario"));
  std::error_code error;
  if (!arguments.has("--scenario") && !std::filesystem::exists(path, error)) path = file.parent_path() / path;
  auto scenario = collision::LoadResolvedScenario(path);
  if (!scenario) {
    return core::Fail(core::ErrorCode::kNotFound,
                      scene::Format(scenario.error().front()) + "; name the scenario of the recording with --scenario");
  }
  return *scenario;
}

void ReportPlatformDifferences(const lockstep::RecordedNode& recorded, const scene::Scenario& scenario) {
  const bus::log::TextMap here = replay::DescribeRun(scenario);
  if (TextOrUnknown(recorded.about, "scenario_digest") != here.at("scenario_digest")) {
    std::printf("%s: NOTE the scenario is not the one that was recorded (digest %s, now %s)\n", recorded.node.c_str(),
                TextOrUnknown(recorded.about, "scenario_digest").c_str(), here.at("scenario_digest").c_str());
  }
  if (replay::GivesSameBits(recorded.about, here)) return;
  std::printf("%s: NOTE recorded with %s, %s, %s; here are %s, %s, %s: numbers may differ by rounding\n",
              recorded.node.c_str(), TextOrUnknown(recorded.about, "simd").c_str(),
              TextOrUnknown(recorded.about, "libm").c_str(), TextOrUnknown(recorded.about, "compiler").c_str(),
              here.at("simd").c_str(), here.at("libm").c_str(), here.at("compiler").c_str());
}

core::Result<lockstep::StepsOptions> ReadOptions(const Arguments& arguments) {
  lockstep::StepsOptions options;
  options.node.cache = vps::DefaultCacheFolder();
  const std::string speed = arguments.text("--speed", "max");
  if (speed != "max") {
    const auto number = arguments.number("--speed");
    if (!number || !*number || !(**number > 0.0)) {
      return core::Fail(core::ErrorCode::kInvalidInput, "--speed needs max or a number above 0");
    }
    options.speed = **number;
  }
  if (arguments.has("--tolerance")) {
    auto tolerance = replay::Tolerance::Read(arguments.text("--tolerance"));
    if (!tolerance) return tl::unexpected(tolerance.error());
    options.tolerance = std::move(*tolerance);
  }
  for (const std::string& text : arguments.texts("--set")) {
    const std::size_t equals = text.rfind('=');
    char* end = nullptr;
    const std::string number = equals == std::string::npos ? "" : text.substr(equals + 1);
    const double value = std::strtod(number.c_str(), &end);
    if (number.empty() || *end != '\0') {
      return core::Fail(core::ErrorCode::kInvalidInput, "--set needs PARAM=NUMBER, not '" + text + "'");
    }
    options.mutations.push_back({text.substr(0, equals), value});
  }
  return options;
}

// Of --set: names without the node before them.
core::Result<void> CheckNames(const std::vector<core::ParameterChange>& changes, const scene::Scenario& scenario) {
  const std::vector<std::string> known = logic_node::ParameterNames(scenario);
  for (const core::ParameterChange& change : changes) {
    if (std::find(known.begin(), known.end(), change.name) != known.end()) continue;
    const std::string nearest = core::NearestName(change.name, known);
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "--set: no node has the parameter '" + change.name + "'" +
                          (nearest.empty() ? ";" : "; did you mean '" + nearest + "'?") +
                          " 'oos check SCENARIO --json' lists them, each behind its node's name");
  }
  return {};
}

int RunSteps(const Arguments& arguments) {
  const std::filesystem::path file = arguments.positional()[0];
  const auto nodes = lockstep::ReadRecordedNodes(file);
  if (!nodes) return Complain("replay", nodes.error().detail, kBadUsage);
  const auto options = ReadOptions(arguments);
  if (!options) return Complain("replay", options.error().detail, kBadUsage);
  const std::string wanted = arguments.text("--node");
  int worst = kHolds;
  bool is_there = false;
  for (const lockstep::RecordedNode& recorded : *nodes) {
    if (!wanted.empty() && recorded.node != wanted) continue;
    is_there = true;
    const auto scenario = FindScenario(arguments, file, recorded);
    if (!scenario) return Complain("replay", scenario.error().detail, kBadUsage);
    if (const auto checked = CheckNames(options->mutations, *scenario); !checked) {
      return Complain("replay", checked.error().detail, kBadUsage);
    }
    ReportPlatformDifferences(recorded, *scenario);
    const auto outcome = lockstep::ReplaySteps(file, recorded, *scenario, *options);
    if (!outcome) {
      worst = Complain("replay", file.string() + ", " + recorded.node + ": " + outcome.error().detail, kBadUsage);
      continue;
    }
    std::printf("%s", Describe(recorded, *outcome).c_str());
    std::fflush(stdout);
    if (outcome->num_different > 0) worst = std::max(worst, kDoesNotHold);
  }
  if (is_there) return worst;
  return Complain("replay",
                  file.string() + ": no steps of " + (wanted.empty() ? "any node" : wanted) +
                      " are in it; 'oos run --lockstep --steps FILE' and the nodes' option --steps FILE record them",
                  kBadUsage);
}

int RunVideo(const Arguments& arguments) {
  const auto source = FindPictureSource(arguments.positional()[0], arguments.text("--scenario"));
  if (!source) return Complain("replay", source.error().detail, kBadUsage);
  if (source->recording.empty()) {
    return Complain("replay", arguments.positional()[0] + " is no recording, and --video needs one", kBadUsage);
  }
  VideoOptions options;
  options.file = arguments.text("--video");
  options.frames_per_s = arguments.checked_number("--fps");
  const std::pair<const char*, const char*> passed_on[] = {
      {"--camera", "--view"},   {"--layout", "--layout"},
      {"--stereo", "--stereo"}, {"--eye_distance_mm", "--eye_distance_mm"},
      {"--size", "--size"},     {"--from", "--from"},
      {"--to", "--to"},         {"--speed", "--speed"}};
  for (const auto& [option, as] : passed_on) {
    if (arguments.has(option)) options.frames.insert(options.frames.end(), {as, arguments.text(option)});
  }
  if (const auto made = MakeVideo(*source, options); !made) {
    const bool is_input_bad = made.error().code == core::ErrorCode::kInvalidInput;
    return Complain("replay", made.error().detail, is_input_bad ? kBadUsage : kDoesNotHold);
  }
  std::printf("%s\n", options.file.c_str());
  return kHolds;
}

int RunReplay(const Arguments& arguments) {
  if (arguments.has("--video")) return RunVideo(arguments);
  return arguments.has("--node") || arguments.has("--check") ? RunSteps(arguments) : RunBusReplay(arguments);
}

std::vector<Option> Options() {
  std::vector<Option> options = {
      {"--node", "NODE", "logic_node, physics_node or haptic_node: feed it its recorded inputs, compare its outputs"},
      {"--check", "", "the same for every node whose steps are in the file"},
      {"--speed", "X|max", "factor to real time; default: max with --node and --check, otherwise 1"},
      {"--tolerance", "FILE", "lines of PATTERN abs=N rel=N or PATTERN ignore for 'topic:field'; default: bit for bit"},
      {"--scenario", "FILE", "default: the one that the recording names"},
      {"--set", "PARAM=VALUE", "change a parameter at the first step, to see its effect (repeatable)"},
      {"--video", "OUT.mp4",
       "render it frame by frame at recorded time, without a session (needs ffmpeg and a display)"},
      {"--camera", "NAME", "with --video; default: the one named after the procedure step, else the first"},
      {"--layout", "TEXT", "with --video: several views, e.g. 'overview | gripper / *'; *: that of the step"},
      {"--stereo", "MODE", "with --video: side_by_side, top_bottom, anaglyph or interlaced"},
      {"--eye_distance_mm", "MM", "with --stereo: between the pupils; default: 63"},
      {"--fps", "N", "with --video: frames per second", "30", cli::Number(1.0, 1000.0)},
      {"--size", "WxH", "with --video: pixels; default: 640x360"},
      {"--to", "S", "with --video: end at this time; default: the recording's end"},
      {"--from", "S", "on the bus or with --video: begin at this time, with the states as of then"},
      {"--loop", "", "on the bus: repeat until stopped"},
      {"--pause", "", "on the bus: wait for 'play' or 'step'"}};
  options.insert(options.end(), AttachOptions().begin(), AttachOptions().end());
  return options;
}

}  // namespace

Verb ReplayVerb() {
  return {
      "replay",
      "replays a recording: on the bus, node by node with a comparison, or as a video",
      "FILE",
      1,
      1,
      Options(),
      RunReplay,
      "With --node or --check, nodes are fed step by step with their recorded inputs, without a bus, and their "
      "outputs\n"
      "are compared. Exit status 0: equal, 1: different (the first tick, topic and field are named), 2: bad input.\n"
      "With --video the same recording gives the same frames, however long one takes; each is the picture that\n"
      "'oos view FILE --shot --at S' makes. Without a screen: xvfb-run -a oos replay ...\n"
      "Otherwise what nodes published is published again in a running session ('oos registry' makes one). Commands on\n"
      "standard input: pause, play, step [MESSAGES], seek SECONDS, speed X, quit."};
}

}  // namespace oos
