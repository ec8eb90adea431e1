#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "nodes/visual_node/gl/gl_objects.hpp"
#include "view/choices.hpp"

struct ImGuiContext;
struct ImDrawData;

namespace visual_node {

struct MenuInput {
  glm::dvec2 mouse_px{-1.0};  // from the target's top left corner
  bool is_mouse_down = false;
  double scroll = 0.0;
  double dt_s = 0.03;
};

// A list of all that can be shown, to switch on and off with the mouse (Dear ImGui). It is made when it is opened
// first.
class Menu {
 public:
  static core::Result<std::unique_ptr<Menu>> Create();
  ~Menu();
  Menu(const Menu&) = delete;
  Menu& operator=(const Menu&) = delete;

  // Draws it onto a picture that is developed, and changes `choices` as the mouse says.
  void Draw(const MenuInput& input, const std::vector<std::string>& objects, const RenderTarget& target,
            view::Choices* choices);
  // The mouse is over the menu, or has taken hold of it.
  [[nodiscard]] bool has_mouse() const { return has_mouse_; }

 private:
  Menu() = default;
  void Paint(const ImDrawData& data, const RenderTarget& target);

  ImGuiContext* imgui_ = nullptr;
  GlProgram program_;
  GlVertexArray layout_;
  GlTexture font_;
  bool has_mouse_ = false;
};

}  // namespace visual_node
