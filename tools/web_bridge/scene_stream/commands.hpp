#pragma once

#include <optional>
#include <string>
#include <vector>

namespace scene_stream {

// What the bridge asks for, a line each on standard input:
//   set NAME 0|1   a choice by its name (view::SetChoice)
//   rate HZ        most frames per second
//   play | pause | seek S | speed X   of a recording
struct Command {
  enum class Kind { kSet, kRate, kPlay, kPause, kSeek, kSpeed };
  Kind kind = Kind::kPlay;
  std::string name;
  double value = 0.0;
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
