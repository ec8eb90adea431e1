#pragma once

#include <string>

#include "view/free_camera.hpp"
#include "view/scene.hpp"

struct GLFWwindow;

namespace visual_node {

// From where the scene is seen: the camera named after the procedure step if there is one, else the first, until
// somebody chooses: --view NAME, number keys for the named views, mouse (left: orbit, wheel: zoom), WASD and QE to fly,
// 0 to follow the steps again.
class CameraControl {
 public:
  CameraControl(const view::Assets& assets, const std::string& fixed_view);

  // Takes the window's keys and mouse; once, before the first frame. Without it only --view and the steps count.
  void Attach(GLFWwindow* window);
  // Before each frame; dt_s since the last.
  const scene::Camera& Update(const view::Assets& assets, const std::string& step, double dt_s);

  // The named view for a step's picture, whatever somebody looks at.
  [[nodiscard]] const scene::Camera& ForStep(const view::Assets& assets, const std::string& step) const;
  [[nodiscard]] bool TakeScreenshotKey();

 private:
  static CameraControl& Of(GLFWwindow* window);
  void Key(int key);

  GLFWwindow* window_ = nullptr;
  view::FreeCamera camera_;
  std::string fixed_view_;
  bool follows_steps_ = true;
  bool is_screenshot_wanted_ = false;
  int wanted_view_ = -1;  // by number key
  double last_x_ = 0.0, last_y_ = 0.0;
  double scroll_ = 0.0;
};

}  // namespace visual_node
