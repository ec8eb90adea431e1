#include "tools/web_bridge/scene_stream/commands.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <sstream>

namespace scene_stream {

std::optional<Command> ParseCommand(const std::string& line) {
  using Kind = Command::Kind;
  std::istringstream words(line);
  std::string word, rest;
  Command command;
  words >> word;
  if (word == "set" && words >> command.name >> command.value && !(words >> rest)) {
    command.kind = Kind::kSet;
    return command;
  }
  for (const auto& [name, kind] : {std::pair{"play", Kind::kPlay}, {"pause", Kind::kPause}}) {
    if (word == name && !(words >> rest)) return Command{kind, "", 0.0};
  }
  for (const auto& [name, kind] : {std::pair{"rate", Kind::kRate}, {"seek", Kind::kSeek}, {"speed", Kind::kSpeed}}) {
    if (word != name || !(words >> command.value) || words >> rest) continue;
    const double least = kind == Kind::kSeek ? 0.0 : 0.01;
    if (!(command.value >= least && command.value <= 1e6)) return std::nullopt;
    command.kind = kind;
    return command;
  }
  return std::nullopt;
}

std::vector<Command> CommandLines::Take() {
  std::vector<Command> commands;
  pollfd input{file_, POLLIN, 0};
  while (is_open_ && poll(&input, 1, 0) == 1) {
    std::array<char, 4096> bytes;
    const ssize_t num = read(file_, bytes.data(), bytes.size());
    is_open_ = num > 0;
    if (is_open_) rest_.append(bytes.data(), static_cast<std::size_t>(num));
  }
  for (std::size_t end = rest_.find('\n'); end != std::string::npos; end = rest_.find('\n')) {
    if (auto command = ParseCommand(rest_.substr(0, end))) commands.push_back(std::move(*command));
    rest_.erase(0, end + 1);
  }
  return commands;
}

}  // namespace scene_stream
