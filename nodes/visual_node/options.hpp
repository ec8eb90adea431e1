#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "bus/log/node_recording.hpp"
#include "bus/node.hpp"
#include "cli/arguments.hpp"
#include "core/result.hpp"
#include "nodes/visual_node/walls/wall_link.hpp"
#include "view/frustum.hpp"
#include "view/stereo.hpp"

namespace visual_node {

// Pictures without a bus: of the scenario as it begins, or of a recording. A file that is not wanted is empty.
struct PictureOptions {
  std::filesystem::path recording;
  std::filesystem::path shot;   // --shot: PNG
  std::filesystem::path depth;  // --depth: PNG of 16 bits in millimetres, or PFM in metres
  std::filesystem::path ids;    // --ids: PNG of 16 bits, with the names beside it as .json
  std::filesystem::path hdr;    // --hdr: PFM, light before exposure and tone curve
  std::optional<double> at_s;   // default: the recording's end
  bool are_frames = false;      // --frames: the recording as a film on stdout
  double from_s = 0.0;          // of the film, from the recording's first message
  std::optional<double> to_s;   // default: the recording's end
  double speed = 1.0;           // recorded seconds per second of the film
  [[nodiscard]] bool is_shot() const { return !shot.empty() || !depth.empty() || !ids.empty() || !hdr.empty(); }
};

struct Options {
  std::filesystem::path scenario;
  bus::NodeOptions node;  // a second viewer of the session has another name, "visual_node-2"
  std::filesystem::path out = ".";
  bus::log::RecordingOptions recording;
  int width = 640;  // of pictures that are kept, and of what is drawn without a window
  int height = 360;
  int window_width = 1280;
  int window_height = 720;
  std::string show;    // --show: what is shown over the scene at first, see view::ReadChoices
  std::string view;    // camera to stay with; empty: the camera named after the step, else the first
  std::string layout;  // several views in the window, see view::ReadLayout
  view::Stereo stereo = view::Stereo::kNone;
  double eye_distance_m = view::kEyeDistance_m;
  std::string head;                      // user for whose head the picture is drawn; empty: for the viewpoint
  std::optional<view::Screen> screen_R;  // of a wall
  std::optional<WallPlace> wall;
  std::optional<glm::ivec2> window_place_px;  // on the display, without a frame
  bool is_headless = false;
  bool steers_hand = false;  // --hand: a person steers a simulated arm's hand from this window
  double max_frames_per_s = 30.0;
  bool is_rate_given = false;  // false: with a graphics card as many as its screen shows
  bool is_full_size = false;   // live pictures are never smaller than the window, however slow the machine
  bool is_still = false;       // --still: each named camera once, without any bus
  int film_fd = -1;            // --film_fd: an open file that gets each picture that is shown, as a film
  PictureOptions pictures;
};

cli::Syntax CommandLineSyntax();

// From a command line of that syntax. Errors: kInvalidInput, when options that belong together are not all there.
core::Result<Options> ReadOptions(const cli::Arguments& arguments);

}  // namespace visual_node
