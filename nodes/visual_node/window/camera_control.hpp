#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

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

  // Lets the view be carried by an object, from where the camera is in `scene`; or, when it is carried, leaves it
  // there.
  void FollowOrLeave(const view::Scene& scene, int object);
  // Keeps the present view: number keys after those of the scenario's cameras go back to it.
  void SaveView();
  [[nodiscard]] const std::vector<scene::Camera>& saved_views() const { return saved_; }
  void SetSavedViews(std::vector<scene::Camera> views) { saved_ = std::move(views); }

  // The camera for a step's picture, independent of keys and mouse.
  [[nodiscard]] const scene::Camera& ForStep(const view::Assets& assets, const std::string& step) const;
  // Keys that were pressed since the last call and do not steer a camera, as GLFW names them.
  [[nodiscard]] std::vector<int> TakeKeys();
  // Where the left button was pressed and let go without a drag since the last call [px of the framebuffer].
  [[nodiscard]] std::optional<glm::dvec2> TakeClick();
  // The mouse belongs to something else, so it neither turns the camera nor clicks.
  void LetMouseGo(bool is_let_go) { is_mouse_let_go_ = is_let_go; }
  [[nodiscard]] double TakeScroll();
  [[nodiscard]] glm::dvec2 MousePixel() const;

 private:
  static CameraControl& Of(GLFWwindow* window);
  void Key(int key);
  void MouseButton(bool is_down);

  GLFWwindow* window_ = nullptr;
  view::FreeCamera camera_;
  std::string fixed_view_;
  std::vector<scene::Camera> saved_;
  bool follows_steps_ = true;
  std::vector<int> keys_;
  std::optional<glm::dvec2> pressed_px_;
  std::optional<glm::dvec2> click_px_;
  bool is_mouse_let_go_ = false;
  int wanted_view_ = -1;  // chosen by a number key
  double last_x_ = 0.0, last_y_ = 0.0;
  double scroll_ = 0.0;
};

}  // namespace visual_node
