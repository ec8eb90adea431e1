#include "view/layout.hpp"

#include "core/names.hpp"

namespace view {
namespace {

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

std::string Trim(const std::string& text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

// Where the k-th of n equal parts of a length begins. Even, so that half a window has whole pixels of it.
int Edge(std::size_t k, std::size_t n, int length) {
  if (k == n) return length + kPaneGap_px;
  return static_cast<int>(k * static_cast<std::size_t>(length + kPaneGap_px) / n / 2 * 2);
}

}  // namespace

core::Result<Layout> ReadLayout(const std::string& text, const Assets& assets) {
  Layout layout;
  layout.rows.clear();
  for (const std::string& row : Split(text, '/')) {
    layout.rows.emplace_back();
    for (const std::string& part : Split(row, '|')) {
      const std::string name = Trim(part);
      if (name.empty()) {
        return core::Fail(core::ErrorCode::kInvalidInput,
                          "the layout '" + text +
                              "' has a view without a name; write cameras' names with | between those side by side "
                              "and / between rows, and * for the view of the procedure's step");
      }
      const std::string camera = name == "*" ? "" : name;
      if (auto known = CheckCamera(assets, camera); !known) return tl::unexpected(known.error());
      layout.rows.back().push_back(camera);
    }
  }
  return layout;
}

std::vector<Pane> PanesOf(const Layout& layout, int width, int height) {
  std::vector<Pane> panes;
  for (std::size_t row = 0; row < layout.rows.size(); ++row) {
    const std::vector<std::string>& cameras = layout.rows[row];
    const int y = Edge(row, layout.rows.size(), height);
    const int high = Edge(row + 1, layout.rows.size(), height) - y - kPaneGap_px;
    for (std::size_t column = 0; column < cameras.size(); ++column) {
      const int x = Edge(column, cameras.size(), width);
      const int wide = Edge(column + 1, cameras.size(), width) - x - kPaneGap_px;
      panes.push_back({cameras[column], {x, y}, {wide, high}});
    }
  }
  return panes;
}

}  // namespace view
