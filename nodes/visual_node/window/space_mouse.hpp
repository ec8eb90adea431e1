#pragma once

#include <glm/glm.hpp>

#include "view/hand_steering.hpp"

namespace visual_node {

// A SpaceMouse by its daemon (spacenavd, or that of its maker), which may start and end while this runs. There is one
// for a process. Nothing blocks, but that to connect to a daemon of the first protocol takes 0.3 s.
class SpaceMouse {
 public:
  SpaceMouse() = default;
  ~SpaceMouse();
  SpaceMouse(const SpaceMouse&) = delete;
  SpaceMouse& operator=(const SpaceMouse&) = delete;

  // Takes what has come, and adds how the cap is pushed and turned. now_s: of any steady clock.
  void Read(double now_s, view::SteeringWish* wish);
  // What has come is not meant for this window.
  void Drop(double now_s);

  [[nodiscard]] bool is_there() const { return is_open_; }
  // Presses of the left and the right button since the last call.
  int TakeLeftPresses();
  int TakeRightPresses();

 private:
  void Take(double now_s);
  void Close();

  bool is_open_ = false;
  double next_try_s_ = 0.0;
  glm::dvec3 push_{0.0}, turn_{0.0};  // as SteeringWish
  int left_presses_ = 0, right_presses_ = 0;
};

}  // namespace visual_node
