#pragma once

#include "nodes/visual_node/window/rumble.hpp"
#include "view/hand_steering.hpp"

namespace visual_node {

// The first gamepad that is there, by GLFW. Left stick: right and up; right stick: away, and with the right shoulder
// held, which turns instead of pushing, about the viewing direction; right trigger: the jaws; left shoulder: fine; A:
// grip; X: where to go next; Y: be shown it. Its motors shake with the felt force.
class Gamepad {
 public:
  // Adds what sticks and buttons wish.
  void Read(view::SteeringWish* wish);
  // Share of the force cap that is felt, 0 to 1. now_s: of any steady clock.
  void Shake(double share, double now_s) { rumble_.Set(share, now_s); }

  [[nodiscard]] bool is_there() const { return is_there_; }
  [[nodiscard]] bool has_motors() const { return rumble_.is_there(); }
  [[nodiscard]] double trigger() const { return trigger_; }  // 0 to 1
  // Whether the button was pressed since the last call.
  bool TakeGrip() { return Take(&grip_); }
  bool TakeNext() { return Take(&next_); }

 private:
  struct Button {
    bool is_down = false, was_pressed = false;
    void Put(bool down) {
      was_pressed = was_pressed || (down && !is_down);
      is_down = down;
    }
  };
  static bool Take(Button* button) {
    const bool was_pressed = button->was_pressed;
    button->was_pressed = false;
    return was_pressed;
  }

  bool is_there_ = false;
  double trigger_ = 0.0;
  Button grip_, next_;
  Rumble rumble_;
};

}  // namespace visual_node
