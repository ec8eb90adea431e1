#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "view/scene.hpp"

namespace view {

// How a window is divided between cameras: rows from the top, each of one view or several, all of the same height, and
// the views of a row all of the same width.
struct Layout {
  std::vector<std::vector<std::string>> rows = {{""}};  // cameras' names; empty: the view of the procedure's step

  [[nodiscard]] bool is_divided() const { return rows.size() > 1 || rows.front().size() > 1; }
  [[nodiscard]] std::size_t num_views() const {
    std::size_t count = 0;
    for (const std::vector<std::string>& row : rows) count += row.size();
    return count;
  }
  // The view that keys and mouse steer: the one at the top left.
  [[nodiscard]] const std::string& steered() const { return rows.front().front(); }
};

// From a text such as "overview | gripper / operator": overview and gripper side by side, operator below them. `*`: the
// view of the procedure's step. Error: kInvalidInput, naming all cameras.
core::Result<Layout> ReadLayout(const std::string& text, const Assets& assets);

// A part of a window in pixels from the top left corner.
struct Pane {
  std::string camera;
  glm::ivec2 corner_px{0};
  glm::ivec2 size_px{0};
};

constexpr int kPaneGap_px = 2;

// The views' places in a window, row by row, with a gap between them.
std::vector<Pane> PanesOf(const Layout& layout, int width, int height);

}  // namespace view
