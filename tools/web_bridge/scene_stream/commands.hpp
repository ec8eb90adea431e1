#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene/scenario.hpp"
#include "view/hand_steering.hpp"

namespace scene_stream {

// What the bridge asks for, a line each on standard input:
//   set NAME 0|1   a choice by its name (view::SetChoice)
//   hand NUMBER... a person steers a hand; the numbers: ReadHand
//   rate HZ        most frames per second
//   play | pause | seek S | speed X   of a recording
struct Command {
  enum class Kind { kSet, kRate, kPlay, kPause, kSeek, kSpeed, kHand };
  Kind kind = Kind::kPlay;
  std::string name;
  double value = 0.0;
  struct Hand {
    view::SteeringWish wish;
    bool shows_next = false;
    std::uint8_t role = 0;
    double dt_s = 0.0;       // since the page's last picture
    double height_px = 1.0;  // of the picture
    scene::Camera camera;    // of the page, in W
  };
  std::optional<Hand> hand;  // of kHand
};

// Nothing: no command.
std::optional<Command> ParseCommand(const std::string& line);

// Takes complete lines off a file descriptor and never waits.
class CommandLines {
 public:
  explicit CommandLines(int file) : file_(file) {}
  std::vector<Command> Take();

 private:
  int file_;
  bool is_open_ = true;
  std::string rest_;
};

}  // namespace scene_stream
