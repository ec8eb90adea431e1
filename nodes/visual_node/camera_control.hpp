#pragma once

#include <string>

#include "view/free_camera.hpp"
#include "view/scene.hpp"

struct GLFWwindow;

namespace visual_node {

// Chooses the camera: the one named after the procedure step, else the first. A person overrides it with --view NAME,
// the number keys (named views), the mouse (left: orbit, wheel: zoom) or WASD and QE (fly); 0 follows the steps again.
class CameraControl {
 public:
  CameraControl(const view::Assets& assets, const std::string& fixed_view);

  // Registers for the window's keys and mouse; once, before the first frame. Without it only --view and the steps have
  // an effect.
  void Attach(GLFWwindow* window);
  // The camera of the next frame; dt_s since the last one.
  const scene::Camera& Update(const view::Assets& assets, const std::string& step, double dt_s);

  // The camera for a step's picture, independent of keys and mouse.
  [[nodiscard]] const scene::Camera& ForStep(const view::Assets& assets, const std::string& step) const;
  // Whether the key was pressed since the last call: P, F11.
  [[nodiscard]] bool TakeScreenshotKey();
  [[nodiscard]] bool TakeFullScreenKey();

 private:
  static CameraControl& Of(GLFWwindow* window);
  void Key(int key);

  GLFWwindow* window_ = nullptr;
  view::FreeCamera camera_;
  std::string fixed_view_;
  bool follows_steps_ = true;
  bool is_screenshot_wanted_ = false;
  bool is_full_screen_wanted_ = false;
  int wanted_view_ = -1;  // chosen by a number key
  double last_x_ = 0.0, last_y_ = 0.0;
  double scroll_ = 0.0;
};

}  // namespace visual_node
