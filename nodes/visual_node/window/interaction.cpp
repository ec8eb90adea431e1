#include "nodes/visual_node/window/interaction.hpp"

#include <algorithm>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace visual_node {
namespace {

// GLFW's keys of characters are their ASCII codes.
std::optional<view::Overlay> OverlayOfKey(int key) {
  if (key <= GLFW_KEY_SPACE || key > GLFW_KEY_GRAVE_ACCENT) return std::nullopt;
  return view::FindOverlayOfKey(static_cast<char>(key));
}

view::Choices::Object* Selected(view::Choices* choices) {
  if (choices->selected < 0) return nullptr;
  const auto selected = static_cast<std::size_t>(choices->selected);
  choices->objects.resize(std::max(choices->objects.size(), selected + 1));
  return &choices->objects[selected];
}

}  // namespace

void Interaction::TakeKey(int key, const view::Scene& scene, CameraControl* control, Wishes* wishes) {
  if (key == GLFW_KEY_P) wishes->is_screenshot_wanted = true;
  if (key == GLFW_KEY_F11) wishes->is_full_screen_wanted = true;
  if (key == GLFW_KEY_J) control->FollowOrLeave(scene, receiver_->choices().selected);
  if (key == GLFW_KEY_Y) {
    control->SaveView();
    wishes->is_view_saved = true;
  }
  if (key == GLFW_KEY_TAB) is_menu_open_ = !is_menu_open_;
  receiver_->Choose([&](view::Choices& choices) {
    if (const auto overlay = OverlayOfKey(key)) choices.overlays.flip(view::IndexOf(*overlay));
    if (key == GLFW_KEY_BACKSPACE) {
      choices.objects.clear();
      choices.selected = -1;
    }
    view::Choices::Object* selected = Selected(&choices);
    if (selected == nullptr) return;
    for (const view::PartChoice& choice : view::kPartChoices) {
      if (key == choice.key) selected->*choice.flag = !(selected->*choice.flag);
    }
  });
}

core::Result<void> Interaction::Pick(const Composer::Shown& shown, const RenderTarget& target,
                                     const glm::dvec2& at_px) {
  if (!objects_) {
    auto pass = ObjectPass::Create();
    if (!pass) return tl::unexpected(pass.error());
    objects_ = std::move(*pass);
  }
  const auto spot = Composer::Find(shown, target.width(), target.height(), at_px);
  if (!spot) return {};
  const ObjectPicture picture = objects_->Draw(*renderer_, shown.scene, spot->eye, spot->size_px.x, spot->size_px.y);
  const int id = *picture.ids.Pixel(static_cast<int>(spot->at_px.x), static_cast<int>(spot->at_px.y));
  receiver_->Choose([&](view::Choices& choices) { choices.selected = choices.selected == id - 1 ? -1 : id - 1; });
  return {};
}

core::Result<Interaction::Wishes> Interaction::Take(const Composer::Shown& shown, const RenderTarget& target,
                                                    CameraControl* control) {
  Wishes wishes;
  for (const int key : control->TakeKeys()) TakeKey(key, shown.scene, control, &wishes);
  if (const auto click = control->TakeClick()) {
    if (auto picked = Pick(shown, target, *click); !picked) return tl::unexpected(picked.error());
  }
  return wishes;
}

core::Result<void> Interaction::DrawMenu(const view::Assets& assets, const RenderTarget& target, bool is_mouse_down,
                                         double dt_s, CameraControl* control) {
  control->LetMouseGo(is_menu_open_ && menu_ != nullptr && menu_->has_mouse());
  if (!is_menu_open_) return {};
  if (menu_ == nullptr) {
    auto menu = Menu::Create();
    if (!menu) return tl::unexpected(menu.error());
    menu_ = std::move(*menu);
  }
  view::Choices choices = receiver_->choices();
  const double scroll = menu_->has_mouse() ? control->TakeScroll() : 0.0;
  menu_->Draw({control->MousePixel(), is_mouse_down, scroll, dt_s}, assets.instance_names, target, &choices);
  receiver_->Choose([&](view::Choices& current) { current = choices; });
  return {};
}

}  // namespace visual_node
