#include "tools/web_bridge/scene_stream/commands.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

namespace scene_stream {
namespace {

// The numbers of `hand`, in their order: held, turns, fine, shown the step, where next (0 or 1); jaws (0 open, 1
// closed); role; drag right, up [px]; wheel; push right, up, away; turn about these; dt [s]; height [px]; the camera's
// eye x y z, target x y z [m], vertical field of view [rad].
constexpr std::size_t kHandNumbers = 25;

std::optional<Command> ReadHand(std::istringstream* words) {
  std::array<double, kHandNumbers> n{};
  std::string rest;
  for (double& number : n) {
    if (!(*words >> number) || !std::isfinite(number) || std::abs(number) > 1e6) return std::nullopt;
  }
  if (*words >> rest) return std::nullopt;
  Command::Hand hand;
  hand.wish.is_held = n[0] != 0.0;
  hand.wish.turns = n[1] != 0.0;
  hand.wish.is_fine = n[2] != 0.0;
  hand.wish.wants_guidance = n[3] != 0.0;
  hand.shows_next = n[4] != 0.0;
  hand.wish.closing = std::clamp(n[5], 0.0, 1.0);
  hand.role = static_cast<std::uint8_t>(std::clamp(n[6], 0.0, 255.0));
  hand.wish.drag_px = {n[7], n[8]};
  hand.wish.wheel = n[9];
  hand.wish.push = glm::clamp(glm::dvec3(n[10], n[11], n[12]), -1.0, 1.0);
  hand.wish.turn = glm::clamp(glm::dvec3(n[13], n[14], n[15]), -1.0, 1.0);
  hand.dt_s = std::clamp(n[16], 0.0, 0.2);
  hand.height_px = std::max(1.0, n[17]);
  hand.camera.eye_m = {n[18], n[19], n[20]};
  hand.camera.target_m = {n[21], n[22], n[23]};
  hand.camera.vertical_fov_rad = std::clamp(n[24], 0.01, 3.0);
  if (hand.camera.eye_m == hand.camera.target_m) return std::nullopt;
  Command command;
  command.kind = Command::Kind::kHand;
  command.hand = hand;
  return command;
}

}  // namespace

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
  if (word == "hand") return ReadHand(&words);
  for (const auto& [name, kind] : {std::pair{"play", Kind::kPlay}, {"pause", Kind::kPause}}) {
    if (word == name && !(words >> rest)) return Command{kind, "", 0.0, {}};
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
