#pragma once

#include <string>

namespace visual_node {

// The motors of a gamepad, by Linux' force feedback (linux/input.h): GLFW has none. A pad without motors, or one that
// this user may not write to, stays still.
class Rumble {
 public:
  Rumble() = default;
  ~Rumble();
  Rumble(const Rumble&) = delete;
  Rumble& operator=(const Rumble&) = delete;

  // The pad of that name, vendor and product, as GLFW gives them (the GUID is SDL's); of several that are alike the
  // first.
  void Choose(const std::string& name, const std::string& guid);
  // Shakes with that share of full strength, 0 to 1. Called at least five times a second: without calls the pad stops
  // by itself. now_s: of any steady clock.
  void Set(double share, double now_s);

  [[nodiscard]] bool is_there() const { return file_ >= 0; }

 private:
  void Close();

  std::string chosen_;  // name and GUID
  int file_ = -1;
  short effect_ = -1;  // number that the driver gave it
  double share_ = 0.0, sent_s_ = 0.0;
};

}  // namespace visual_node
