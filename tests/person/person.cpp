#include "tests/person/person.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "core/clock.hpp"

namespace person_tests {
namespace {

constexpr int kRightButton = 3;
constexpr double kWheel_mm = 10.0, kFineWheel_mm = 2.0;  // a notch
constexpr double kTurn_deg_per_px = 0.286;               // as this person has learned
constexpr double kFineTurn_deg_per_notch = 1.15;
// Of one movement, a share of the way: a stroke of an empty hand, and of one that carries a part. A short way is made
// at once.
constexpr double kStrokeShare = 0.85, kCarryShare = 0.5, kCarry_mm = 60.0, kShort_mm = 12.0;
constexpr int kEdge_px = 60;

double Signed(const std::string& word, double value) {
  return word == "left" || word == "down" || word == "near" ? -value : value;
}

// "right 12.0, down 3.1 mm"
void ReadWords(const std::string& part, double* x, double* y, double* z) {
  std::istringstream words(part);
  std::string word;
  double value = 0.0;
  while (words >> word) {
    if (!(words >> value)) return;
    double* const axis = word == "right" || word == "left" ? x : word == "up" || word == "down" ? y : z;
    *axis = Signed(word, value);
    if (words.peek() == ',') words.ignore();
    if (words.peek() != ' ') return;
    const auto at = words.tellg();
    words >> word;
    if (word != "mm" && word != "deg") words.seekg(at);
  }
}

}  // namespace

double Sight::way_mm() const {
  return std::hypot(x, y, z);
}

double Sight::turn_deg() const {
  return std::hypot(turn_x, turn_y, turn_z);
}

std::optional<Sight> Understand(const std::vector<std::string>& lines) {
  Sight sight;
  bool has_hand = false, has_next = false;
  for (const std::string& line : lines) {
    if (line.starts_with("hand ")) {
      has_hand = true;
      sight.is_closing = line.find("jaws closing") != std::string::npos;
    }
    if (!line.starts_with("next: ")) continue;
    has_next = true;
    sight.next = line.substr(6);
    const std::size_t turns = sight.next.find("Ctrl: ");
    if (turns != 0) ReadWords(sight.next.substr(0, sight.next.find(';')), &sight.x, &sight.y, &sight.z);
    if (turns != std::string::npos) {
      ReadWords(sight.next.substr(turns + 6), &sight.turn_x, &sight.turn_y, &sight.turn_z);
    }
  }
  if (!has_hand || !has_next) return std::nullopt;
  return sight;
}

std::optional<Sight> Person::Look() {
  constexpr int kMostLooks = 6;
  std::optional<Sight> seen;
  for (int i = 0; i < kMostLooks; ++i) {
    const auto now = Understand(reader_.Read(window_->LookAfter(2)));
    if (now && seen && now->next == seen->next) return now;
    if (now) seen = now;
  }
  return seen;  // it goes on changing
}

bool Person::Follow(double patience_s, const std::function<bool(const Sight&)>& is_over,
                    const std::atomic<bool>& is_gone) {
  while (!is_gone && reader_.Read(window_->LookAfter(1)).empty()) {
  }
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  const auto seconds = [&] { return 1e-9 * static_cast<double>(core::MonotonicNow_ns() - begin_ns); };
  bool is_done = false;
  window_->MoveTo(Window::kWidth / 2, Window::kHeight / 3);
  while (!is_done && !is_gone && seconds() < patience_s) {
    const auto seen = Look();
    if (!seen) {
      window_->Press("F2");
      continue;
    }
    std::printf("%6.1f s  %s, next: %s\n", seconds(), seen->is_closing ? "closing" : "open", seen->next.c_str());
    std::fflush(stdout);
    is_done = is_over(*seen);
    seconds_ = seconds();
    if (!is_done) Act(*seen);
  }
  if (is_holding_) window_->HoldButton(kRightButton, false);
  return is_done;
}

void Person::Act(const Sight& seen) {
  const bool wants_closed = seen.next == "close the jaws", wants_open = seen.next == "open the jaws";
  if (wants_closed || wants_open) {
    if (wants_closed != seen.is_closing) window_->Press("space");
  } else if (seen.turn_deg() > 0.0 && seen.turn_deg() > 0.3 * seen.way_mm()) {
    Turn(seen);
  } else if (seen.way_mm() > 0.0) {
    Move(seen);
  }
}

// Holds the button all the time; at the window's edge it lets go and takes hold anew in the middle.
void Person::TakeHold(int dx, int dy) {
  const int x = window_->x() + dx, y = window_->y() + dy;
  const bool is_inside =
      x > kEdge_px && x < Window::kWidth - kEdge_px && y > kEdge_px && y < Window::kHeight - kEdge_px;
  if (is_holding_ && is_inside) return;
  if (is_holding_) {
    window_->HoldButton(kRightButton, false);
    window_->MoveTo(Window::kWidth / 2, Window::kHeight / 2);
    Look();  // the viewer, too, has seen it
  }
  window_->HoldButton(kRightButton, true);
  Look();
  is_holding_ = true;
}

void Person::Turn(const Sight& seen) {
  const int dx = static_cast<int>(std::lround(seen.turn_x / kTurn_deg_per_px));
  const int dy = -static_cast<int>(std::lround(seen.turn_y / kTurn_deg_per_px));
  TakeHold(dx, dy);
  window_->HoldKey("ctrl", true);
  Look();
  window_->Drag(dx, dy);
  window_->HoldKey("shift", true);
  Look();
  window_->Wheel(static_cast<int>(std::lround(seen.turn_z / kFineTurn_deg_per_notch)));
  Look();
  window_->HoldKey("shift", false);
  window_->HoldKey("ctrl", false);
  Look();
}

void Person::Move(const Sight& seen) {
  const double way_mm = seen.way_mm();
  const double most_mm = seen.is_closing ? std::min(kCarry_mm, kCarryShare * way_mm) : kStrokeShare * way_mm;
  const double share = way_mm <= kShort_mm ? 1.0 : std::max(kShort_mm, most_mm) / way_mm;
  const int dx = static_cast<int>(std::lround(share * seen.x / mm_per_px_));
  const int dy = -static_cast<int>(std::lround(share * seen.y / mm_per_px_));
  TakeHold(dx, dy);
  window_->Drag(dx, dy);
  const double away_mm = share * seen.z;
  const int coarse = static_cast<int>(away_mm / kWheel_mm);
  window_->Wheel(coarse);
  const int fine = static_cast<int>(std::lround((away_mm - coarse * kWheel_mm) / kFineWheel_mm));
  const auto between = Look();
  if (fine != 0) {
    window_->HoldKey("shift", true);
    Look();
    window_->Wheel(fine);
    Look();
    window_->HoldKey("shift", false);
  }
  // How far a pixel moves the hand depends on how far away it is: seen on the way.
  const double dragged_px = std::hypot(dx, dy);
  if (!between || dragged_px < 15.0) return;
  const double moved_mm = std::hypot(seen.x - between->x, seen.y - between->y);
  const double learned = moved_mm / dragged_px;
  if (learned > 0.1 && learned < 5.0) mm_per_px_ += 0.5 * (learned - mm_per_px_);
}

}  // namespace person_tests
