#include "view/steering_caption.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "view/projection.hpp"

namespace view {
namespace {

constexpr glm::vec3 kHowToColor{0.75f};
constexpr glm::vec3 kHandColor{1.0f, 0.75f, 0.2f};
constexpr glm::vec3 kNextColor{0.35f, 0.65f, 1.0f};  // as planned ways
constexpr int kBarLength = 24;                       // characters
constexpr double kLeastWay_mm = 0.3;                 // less is not told; by hand
constexpr double kLeastTurn_deg = 1.0;
constexpr double kDegrees = 57.29577951308232;

// A value along an axis of the keys, by the name of the key; nothing below `least`.
void AddWord(double value, double least, const char* more, const char* less, std::string* words) {
  if (std::abs(value) < least) return;
  char text[32];
  std::snprintf(text, sizeof text, "%s%s %.*f", words->empty() ? "" : ", ", value > 0.0 ? more : less,
                std::abs(value) < 10.0 ? 1 : 0, std::abs(value));
  *words += text;
}

std::string WordsOfAxes(const glm::dvec3& value, double least, const char* unit) {
  std::string words;
  AddWord(value.x, least, "right", "left", &words);
  AddWord(value.y, least, "up", "down", &words);
  AddWord(value.z, least, "away", "near", &words);
  return words.empty() ? words : words + " " + unit;
}

// With the view's axes r, u and f (right, up, forward): a way w is (w.r, w.u, w.f); a turn t that the keys make is
// (t.u, -t.r, t.f), because an arrow to the right turns about the upward axis (view::HandSteering).
std::string NextLine(const HandGuide& guide, const scene::Camera& camera) {
  const glm::dmat3 R_WE = glm::transpose(glm::dmat3(ViewMatrix(camera)));
  const glm::dvec3 right = R_WE[0], up = R_WE[1], forward = -R_WE[2];
  switch (guide.kind) {
    case core::GuideKind::kNone:
      return "next: the hand is not needed";
    case core::GuideKind::kOpen:
      return "next: open the jaws";
    case core::GuideKind::kClose:
      return "next: close the jaws";
    case core::GuideKind::kWait:
      return "next: wait";
    case core::GuideKind::kMove:
      break;
  }
  const glm::dvec3 way_mm =
      1e3 * glm::dvec3(glm::dot(guide.way_W_m, right), glm::dot(guide.way_W_m, up), glm::dot(guide.way_W_m, forward));
  const glm::dvec3 turn_deg = kDegrees * glm::dvec3(glm::dot(guide.turn_W_rad, up), -glm::dot(guide.turn_W_rad, right),
                                                    glm::dot(guide.turn_W_rad, forward));
  const std::string way = WordsOfAxes(way_mm, kLeastWay_mm, "mm"), turn = WordsOfAxes(turn_deg, kLeastTurn_deg, "deg");
  if (way.empty() && turn.empty()) return "next: hold still";
  return "next: " + way + (way.empty() || turn.empty() ? "" : "; ") + (turn.empty() ? "" : "Ctrl: " + turn);
}

void AddNext(const HandGuide& guide, int palm, Scene* scene) {
  if (guide.kind != core::GuideKind::kMove || palm < 0) return;
  const core::Pose& X_WPalm = scene->instances[static_cast<std::size_t>(palm)].X_WM;
  const core::Pose X_WNext{glm::normalize(core::QuaternionFromRotationVector(guide.turn_W_rad) * X_WPalm.rotation),
                           X_WPalm.translation + guide.way_W_m};
  const std::vector<glm::vec3> way{glm::vec3(X_WPalm.translation), glm::vec3(X_WNext.translation)};
  scene->lines.push_back({std::make_shared<const std::vector<glm::vec3>>(way), kNextColor, 2.5f});
  scene->phantoms.push_back({static_cast<std::uint32_t>(palm), X_WNext, kNextColor, 0.3f});
}

}  // namespace

void DescribeSteering(const scene::Scenario& scenario, const SteeringState& state, const scene::Camera& camera,
                      Scene* scene) {
  const auto add = [scene](const glm::vec3& color, const std::string& text) {
    scene->texts.push_back({Anchor::kBottomLeft, TextStyle::kSmall, color, text});
  };
  const std::size_t role = state.input.role_index;
  if (role >= scenario.devices.size()) return;
  const scene::Device& device = scenario.devices[role];
  const double force_N = role < scene->felt_N.size() ? scene->felt_N[role] : 0.0;
  std::string bar(kBarLength, '.');
  const double share = scenario.force_cap_N > 0.0 ? std::clamp(force_N / scenario.force_cap_N, 0.0, 1.0) : 0.0;
  std::fill_n(bar.begin(), std::lround(share * kBarLength), '|');
  char line[160];
  std::snprintf(line, sizeof line, "hand %s: %s, jaws %s   [%s] %.0f N", device.role.c_str(),
                state.input.wants_guidance ? "guided"
                : state.input.is_held      ? "held"
                                           : "free",
                state.input.closing > 0.5 ? "closing" : "open", bar.c_str(), force_N);
  add(kHandColor, line);
  if (state.shows_next && role < scene->guides.size()) {
    add(kHandColor, NextLine(scene->guides[role], camera));
    AddNext(scene->guides[role], device.palm, scene);
  }
  add(kHowToColor,
      "hold the right button: the hand follows the mouse; wheel: away; Ctrl: turn; Shift: fine; or arrows and page "
      "keys");
  add(kHowToColor, std::string("Space: jaws; F2: where to go next; hold F1: be shown this step") +
                       (scenario.devices.size() > 1 ? "; Insert: other hand" : "") +
                       (state.has_gamepad ? "; gamepad: sticks, A, X, Y" : "") +
                       (state.has_space_mouse ? "; SpaceMouse: cap, both buttons" : ""));
}

}  // namespace view
