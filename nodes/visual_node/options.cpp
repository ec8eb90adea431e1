#include "nodes/visual_node/options.hpp"

#include <algorithm>
#include <sstream>

#include "core/names.hpp"
#include "nodes/run_node/command_line.hpp"

namespace visual_node {
namespace {

constexpr int kLeastSize = 64, kMostSize = 8192;  // pixels

constexpr std::uint64_t kMostPlace = 32767;  // X11's

constexpr double kMostSeconds = 1e6;

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

// "X,Y"
core::Result<void> ReadPlace(const std::string& text, Options* options) {
  const std::size_t comma = std::min(text.find(','), text.size());
  const auto x = cli::ReadCount(text.substr(0, comma)),
             y = cli::ReadCount(text.substr(std::min(comma + 1, text.size())));
  if (!x || !y || *x > kMostPlace || *y > kMostPlace) {
    return core::Fail(core::ErrorCode::kInvalidInput, "--place needs X,Y in pixels of the display, not '" + text + "'");
  }
  options->window_place_px = glm::ivec2(static_cast<int>(*x), static_cast<int>(*y));
  return {};
}

// Nine numbers: lower left, lower right and upper left corner.
core::Result<void> ReadScreen(const std::string& text, Options* options) {
  std::istringstream in(text);
  view::Screen screen;
  double* const numbers[] = {&screen.lower_left.x,  &screen.lower_left.y,  &screen.lower_left.z,
                             &screen.lower_right.x, &screen.lower_right.y, &screen.lower_right.z,
                             &screen.upper_left.x,  &screen.upper_left.y,  &screen.upper_left.z};
  bool is_read = true;
  for (double* number : numbers) is_read = is_read && static_cast<bool>(in >> *number);
  std::string rest;
  if (!is_read || in >> rest) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "--screen needs nine numbers, the corners at the lower left, lower right and upper left in "
                      "metres, not '" +
                          text + "'");
  }
  if (auto flat = view::CheckScreen(screen); !flat) return flat;
  options->screen_R = screen;
  return {};
}

// --wall NAME of --walls A,B,C in --room NAME.
core::Result<void> ReadWall(const cli::Arguments& arguments, Options* options) {
  if (!arguments.has("--wall")) return {};
  WallPlace place;
  place.room = arguments.text("--room");
  std::istringstream in(arguments.text("--walls"));
  for (std::string name; std::getline(in, name, ',');) place.walls.push_back(name);
  const std::string own = arguments.text("--wall");
  const auto at = std::find(place.walls.begin(), place.walls.end(), own);
  if (place.room.empty() || at == place.walls.end() || !options->screen_R) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "--wall " + own +
                          " needs --screen, --room, and --walls with the names of all walls of the room, " + own +
                          " among them");
  }
  place.own = static_cast<std::size_t>(at - place.walls.begin());
  options->wall = std::move(place);
  return {};
}

core::Result<void> ReadViewing(const cli::Arguments& arguments, Options* options) {
  options->layout = arguments.text("--layout");
  options->head = arguments.text("--head");
  options->eye_distance_m = 1e-3 * arguments.checked_number("--eye_distance_mm");
  if (!options->layout.empty() && !options->view.empty()) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "--view and --layout do not go together: the layout names its views itself");
  }
  const std::string mode = arguments.text("--stereo");
  const auto stereo = view::FindStereo(mode);
  if (!stereo) {
    std::vector<std::string> known = {view::NameOf(view::Stereo::kNone)};
    for (const view::StereoInfo& info : view::kStereoModes) known.emplace_back(info.name);
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "unknown --stereo '" + mode + "'; " + core::SuggestName(mode, known));
  }
  options->stereo = *stereo;
  if (arguments.has("--screen")) {
    if (auto read = ReadScreen(arguments.text("--screen"), options); !read) return read;
  }
  if (arguments.has("--place")) {
    if (auto read = ReadPlace(arguments.text("--place"), options); !read) return read;
  }
  return ReadWall(arguments, options);
}

core::Result<void> CheckEnding(const std::filesystem::path& file, const char* option, const char* endings) {
  const std::string ending = file.extension().string();
  if (file.empty() || (!ending.empty() && std::string_view(endings).find(ending) != std::string_view::npos)) return {};
  return core::Fail(core::ErrorCode::kInvalidInput,
                    std::string(option) + " needs a file that ends in " + endings + ", not '" + file.string() + "'");
}

core::Result<PictureOptions> ReadPictureOptions(const cli::Arguments& arguments) {
  PictureOptions pictures;
  pictures.recording = arguments.text("--recording");
  pictures.shot = arguments.text("--shot");
  pictures.depth = arguments.text("--depth");
  pictures.ids = arguments.text("--ids");
  pictures.hdr = arguments.text("--hdr");
  pictures.are_frames = arguments.has("--frames");
  if (arguments.has("--at")) pictures.at_s = arguments.checked_number("--at");
  pictures.from_s = arguments.checked_number("--from");
  if (arguments.has("--to")) pictures.to_s = arguments.checked_number("--to");
  pictures.speed = arguments.checked_number("--speed");
  if (auto good = CheckEnding(pictures.shot, "--shot", ".png"); !good) return tl::unexpected(good.error());
  if (auto good = CheckEnding(pictures.depth, "--depth", ".png or .pfm"); !good) return tl::unexpected(good.error());
  if (auto good = CheckEnding(pictures.hdr, "--hdr", ".pfm"); !good) return tl::unexpected(good.error());
  if (auto good = CheckEnding(pictures.ids, "--ids", ".png"); !good) return tl::unexpected(good.error());
  const auto fail = [](const char* what) { return core::Fail(core::ErrorCode::kInvalidInput, what); };
  if (pictures.recording.empty() && pictures.at_s)
    return fail("--at needs a recording: a scenario is shown as it begins");
  const bool is_measured = !pictures.depth.empty() || !pictures.ids.empty() || !pictures.hdr.empty();
  const bool is_composed = !arguments.text("--layout").empty() || arguments.text("--stereo") != "none";
  if (is_measured && is_composed) return fail("--depth, --ids and --hdr are of one view for one eye");
  if (pictures.recording.empty() && pictures.are_frames) return fail("--frames needs --recording FILE.mcap");
  return pictures;
}

}  // namespace

cli::Syntax CommandLineSyntax() {
  cli::Syntax syntax;
  syntax.program = "visual_node";
  syntax.summary = "shows the scenario as it runs";
  syntax.options = {
      {"--scenario", "FILE", "what is shown"},
      {"--out", "DIR", "of pictures and the report", "."},
      {"--still", "FILE", "each named camera of this scenario once, to DIR; without a bus"},
      {"--name", "NAME", "on the bus", "visual_node"},
      {"--size", "WIDTHxHEIGHT", "of the window and of pictures; default: 1280x720 and 640x360"},
      {"--view", "NAME", "camera to stay with; default: the one named after the step, else the first"},
      {"--show", "LIST",
       "overlays and more, e.g. \"paths no_contacts transparent.cover\"; 'oos set' has the same names"},
      {"--shot", "FILE.png", "one picture, without a bus; also --depth, --ids and --hdr"},
      {"--depth", "FILE", ".png: 16 bits, in mm; .pfm: in m; along the viewing direction, 0: nothing"},
      {"--ids", "FILE.png", "16 bits, the objects' ids, 0: nothing; their names beside it as .json"},
      {"--hdr", "FILE.pfm", "its light before exposure and tone curve: linear RGB"},
      {"--recording", "FILE.mcap", "what --shot and --frames show; default: the scenario as it begins"},
      {"--at", "S", "of the recording, from its first message; default: its end", "", cli::Number(0.0, kMostSeconds)},
      {"--frames", "", "the recording, frame by frame, as PPM pictures on stdout"},
      {"--from", "S", "with --frames: begin at this time", "0", cli::Number(0.0, kMostSeconds)},
      {"--to", "S", "with --frames: end at this time; default: the recording's end", "",
       cli::Number(0.0, kMostSeconds)},
      {"--speed", "X", "with --frames: recorded seconds per second", "1", cli::Number(1e-3, 1e3)},
      {"--layout", "TEXT", "several views: cameras side by side with |, in rows with /; *: that of the step"},
      {"--stereo", "MODE", "side_by_side, top_bottom, anaglyph or interlaced", "none"},
      {"--eye_distance_mm", "MM", "between the pupils", "63", cli::Number(0.0, 1e3 * view::kMostEyeDistance_m)},
      {"--head", "USER", "draw for where this user's head is; default: for the screen's viewpoint"},
      {"--screen", "NUMBERS", "corners of a wall, lower left, lower right, upper left, in metres from the viewpoint"},
      {"--wall", "NAME", "which wall of the room this is, in step with the others"},
      {"--walls", "A,B,C", "all walls of the room; the first decides when all show a picture"},
      {"--room", "NAME", "of the walls"},
      {"--place", "X,Y", "of the window on the display, which then has no frame"},
      {"--headless", "", "renders pictures but shows no window"},
      {"--hand", "", "a person steers a simulated arm's hand from this window, by mouse, keyboard or gamepad"},
      {"--fps", "N",
       "most pictures per second; a slow machine draws them smaller to hold it. With a graphics card: as many as its "
       "screen shows",
       "30", cli::Number(1.0, 1000.0)},
      {"--film_fd", "N", "an open file that gets --fps pictures a second, each as it is shown then, as PPM", "",
       cli::Count(3, 1 << 20)},
      {"--full_size", "", "draws live pictures as large as the window, also when that is too slow for --fps"}};
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
  options.show = arguments.text("--show");
  options.is_headless = arguments.has("--headless");
  options.is_full_size = arguments.has("--full_size");
  options.steers_hand = arguments.has("--hand");
  options.max_frames_per_s = arguments.checked_number("--fps");
  options.is_rate_given = arguments.has("--fps");
  if (arguments.has("--film_fd")) options.film_fd = static_cast<int>(arguments.checked_number("--film_fd"));
  if (arguments.has("--size")) {
    if (auto read = ReadSize(arguments.text("--size"), &options); !read) return tl::unexpected(read.error());
  }
  if (auto read = ReadViewing(arguments, &options); !read) return tl::unexpected(read.error());
  auto pictures = ReadPictureOptions(arguments);
  if (!pictures) return tl::unexpected(pictures.error());
  options.pictures = std::move(*pictures);
  const auto fail = [](const char* what) { return core::Fail(core::ErrorCode::kInvalidInput, what); };
  if (options.is_still) return options;
  if (options.scenario.empty()) return fail("--scenario FILE is missing");
  if (options.pictures.is_shot() || options.pictures.are_frames) return options;
  if (options.node.registry.empty()) return fail("--registry ENDPOINT is missing");
  if (options.node.is_encrypted == options.node.keys.empty()) {
    return fail("either --keys DIR or --no_encryption must be given");
  }
  return options;
}

}  // namespace visual_node
