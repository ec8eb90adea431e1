#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>

#include "tests/person/window.hpp"

namespace person_tests {

// What the captions say.
struct Sight {
  bool is_closing = false;                          // the jaws
  std::string next;                                 // after "next: "
  double x = 0.0, y = 0.0, z = 0.0;                 // right, up, away [mm]
  double turn_x = 0.0, turn_y = 0.0, turn_z = 0.0;  // the same with Ctrl [deg]
  [[nodiscard]] double way_mm() const;
  [[nodiscard]] double turn_deg() const;
};

// Nothing: these lines do not say it.
std::optional<Sight> Understand(const std::vector<std::string>& lines);

// Does what the captions say until `is_over` of what it sees, by mouse and Space. Knows nothing else.
class Person {
 public:
  Person(Window* window, CaptionReader reader) : window_(window), reader_(std::move(reader)) {}
  // Time counts from the first picture. False: it is over, or the window is gone.
  bool Follow(double patience_s, const std::function<bool(const Sight&)>& is_over, const std::atomic<bool>& is_gone);
  // Until the last look.
  [[nodiscard]] double seconds() const { return seconds_; }

 private:
  // Looks until nothing changes any more.
  std::optional<Sight> Look();
  void Act(const Sight& seen);
  void Turn(const Sight& seen);
  void Move(const Sight& seen);
  void TakeHold(int dx, int dy);

  Window* window_;
  CaptionReader reader_;
  double seconds_ = 0.0;
  double mm_per_px_ = 1.0;  // learned
  bool is_holding_ = false;
};

}  // namespace person_tests
