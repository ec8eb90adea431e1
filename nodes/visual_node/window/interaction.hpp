#pragma once

#include <memory>
#include <optional>

#include "core/result.hpp"
#include "nodes/visual_node/draw/composer.hpp"
#include "nodes/visual_node/draw/object_pass.hpp"
#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/receiver.hpp"
#include "nodes/visual_node/window/camera_control.hpp"
#include "nodes/visual_node/window/menu.hpp"

namespace visual_node {

// What a person does in a window beside steering the camera: keys, clicks on objects, and the menu.
class Interaction {
 public:
  struct Wishes {
    bool is_screenshot_wanted = false;
    bool is_full_screen_wanted = false;
    bool is_view_saved = false;  // one more than before, in CameraControl::saved_views
  };

  Interaction(Receiver* receiver, Renderer* renderer) : receiver_(receiver), renderer_(renderer) {}

  // Of the keys and clicks since the last frame, which shows `shown` on `target`.
  core::Result<Wishes> Take(const Composer::Shown& shown, const RenderTarget& target, CameraControl* control);
  // Over the picture, while it is open.
  core::Result<void> DrawMenu(const view::Assets& assets, const RenderTarget& target, bool is_mouse_down, double dt_s,
                              CameraControl* control);
  [[nodiscard]] bool is_menu_open() const { return is_menu_open_; }

 private:
  void TakeKey(int key, const view::Scene& scene, CameraControl* control, Wishes* wishes);
  core::Result<void> Pick(const Composer::Shown& shown, const RenderTarget& target, const glm::dvec2& at_px);

  Receiver* receiver_;
  Renderer* renderer_;
  std::optional<ObjectPass> objects_;  // from the first click on
  std::unique_ptr<Menu> menu_;         // from the first opening on
  bool is_menu_open_ = false;
};

}  // namespace visual_node
