#include "nodes/visual_node/draw/text_painter.hpp"

#include <algorithm>
#include <cmath>

#include "nodes/visual_node/draw/shaders.hpp"

namespace visual_node {
namespace {

constexpr std::array<int, 4> kSizeAt360 = {10, 13, 18, 10};  // letter size [px] by TextStyle, at a height of 360 px
constexpr std::array<bool, 4> kIsBold = {false, false, true, true};

glm::vec3 ToDisplay(const glm::vec3& linear) {
  return glm::pow(linear, glm::vec3(1.0f / 2.2f));
}

constexpr glm::vec4 kBackground{0.02f, 0.03f, 0.05f, 0.62f};
constexpr glm::vec4 kHeadBackground{0.02f, 0.03f, 0.05f, 0.45f};  // these lines are always there

}  // namespace

Hud HudOf(const view::Scene& scene, const view::Frustum& eye, int width, int height) {
  Hud hud{scene.texts, {}, scene.graphs};
  for (const view::Label& label : scene.labels) {
    const glm::dvec3 pixel = view::ProjectToPixel(eye, width, height, label.p_W);
    const bool is_inside = pixel.z > 0.0 && pixel.x >= 0.0 && pixel.x < width && pixel.y >= 0.0 && pixel.y < height;
    if (is_inside) hud.labels.push_back({&label, glm::dvec2(pixel)});
  }
  return hud;
}

core::Result<std::unique_ptr<TextPainter>> TextPainter::Create() {
  auto painter = std::make_unique<TextPainter>();
  auto program = MakeProgram("text", kTextVertex, kTextFragment);
  if (!program) return tl::unexpected(program.error());
  painter->program_ = std::move(*program);
  painter->layout_ = MakeVertexArray();
  const GLuint layout = painter->layout_.id();
  for (const GLuint attribute : {0u, 1u}) {
    glEnableVertexArrayAttrib(layout, attribute);
    glVertexArrayAttribFormat(layout, attribute, 4, GL_FLOAT, GL_FALSE, attribute * 4 * sizeof(float));
    glVertexArrayAttribBinding(layout, attribute, 0);
  }
  const auto fonts = painter->FontsFor(360);  // reports a missing font at the start rather than during the run
  if (!fonts) return tl::unexpected(fonts.error());
  return painter;
}

core::Result<TextPainter::Fonts*> TextPainter::FontsFor(int height) {
  const auto known = fonts_.find(height);
  if (known != fonts_.end()) return &known->second;
  Fonts fonts;
  for (std::size_t style = 0; style < fonts.size(); ++style) {
    auto atlas = GlyphAtlas::Create(std::max(8, kSizeAt360[style] * height / 360), kIsBold[style]);
    if (!atlas) return tl::unexpected(atlas.error());
    fonts[style].texture = MakeTexture(GL_R8, atlas->width(), atlas->height());
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTextureSubImage2D(fonts[style].texture.id(), 0, 0, 0, atlas->width(), atlas->height(), GL_RED, GL_UNSIGNED_BYTE,
                        atlas->coverage().data());
    fonts[style].atlas = std::move(*atlas);
  }
  return &fonts_.emplace(height, std::move(fonts)).first->second;
}

void TextPainter::PlaceLines(const std::vector<view::TextLine>& lines, int width, int height, const Fonts& fonts) {
  placed_.clear();
  const int margin = 10 * height / 360;
  std::array<int, 4> block_height{};
  const auto font = [&](const view::TextLine& line) -> const GlyphAtlas& {
    return fonts[static_cast<std::size_t>(line.style)].atlas;
  };
  for (const view::TextLine& line : lines) {
    block_height[static_cast<std::size_t>(line.anchor)] += font(line).line_height();
  }
  std::array<int, 4> pen{};
  bool is_table_begun = false;
  for (const view::TextLine& line : lines) {
    const auto anchor = static_cast<std::size_t>(line.anchor);
    const bool is_right = line.anchor == view::Anchor::kTopRight || line.anchor == view::Anchor::kBottomRight;
    const bool is_bottom = line.anchor == view::Anchor::kBottomLeft || line.anchor == view::Anchor::kBottomRight;
    PlacedLine item{line, 0, 0, font(line).Width(line.text), font(line).line_height()};
    item.x = is_right ? width - margin - item.width : margin;
    // A table keeps clear of the badge above it.
    if (is_right && !is_bottom && line.style != view::TextStyle::kBadge && pen[anchor] > 0 && !is_table_begun) {
      pen[anchor] += 5 * height / 360;
      is_table_begun = true;
    }
    item.y = (is_bottom ? height - margin - block_height[anchor] : margin) + pen[anchor];
    pen[anchor] += item.height;
    placed_.push_back(item);
  }
  right_end_ = margin + pen[static_cast<std::size_t>(view::Anchor::kTopRight)];
}

// Above their places. A label that would cover one before it moves further up.
void TextPainter::PlaceLabels(const std::vector<Hud::PlacedLabel>& labels, int width, int height, const Fonts& fonts) {
  const int margin = 6 * height / 360;
  const std::size_t first = placed_.size();
  const GlyphAtlas& atlas = fonts[static_cast<std::size_t>(view::TextStyle::kBody)].atlas;
  for (const Hud::PlacedLabel& placed : labels) {
    PlacedLine item;
    item.line = {view::Anchor::kTopLeft, view::TextStyle::kBody, placed.label->color, placed.label->text};
    item.width = atlas.Width(item.line.text);
    item.height = atlas.line_height();
    item.x = static_cast<int>(placed.at_px.x) - item.width / 2;
    item.y = static_cast<int>(placed.at_px.y) - item.height - 8 * height / 360;
    const auto covers = [&](const PlacedLine& other) {
      return std::abs(other.y - item.y) < item.height && other.x < item.x + item.width &&
             item.x < other.x + other.width;
    };
    for (std::size_t tries = 0; tries < labels.size(); ++tries) {
      const auto other = std::find_if(placed_.begin() + static_cast<std::ptrdiff_t>(first), placed_.end(), covers);
      if (other == placed_.end()) break;
      item.y = other->y - item.height;
    }
    item.x = std::clamp(item.x, margin, std::max(margin, width - margin - item.width));
    // One that would leave the picture at the top stands below its place.
    if (item.y < margin) item.y = static_cast<int>(placed.at_px.y) + 8 * height / 360;
    placed_.push_back(item);
  }
}

// Below the lines at the top right, one under the other.
void TextPainter::DrawGraphs(const std::vector<view::Graph>& graphs, int width, int height, const Fonts& fonts) {
  const auto unit = static_cast<float>(height) / 360.0f;
  const GlyphAtlas& atlas = fonts[static_cast<std::size_t>(view::TextStyle::kSmall)].atlas;
  const float graph_width = 150 * unit, bars_height = 26 * unit, right = static_cast<float>(width) - 10 * unit;
  const float left = right - graph_width;
  float top = static_cast<float>(right_end_) + 6 * unit;
  for (const view::Graph& graph : graphs) {
    const float bars_top = top + static_cast<float>(atlas.line_height());
    const float bottom = bars_top + bars_height;
    AddPanel(left - 4 * unit, top - 2 * unit, right + 4 * unit, bottom + 2 * unit, kBackground);
    PlacedLine title;
    title.line = {view::Anchor::kTopRight, view::TextStyle::kSmall, graph.color, graph.title};
    title.x = static_cast<int>(left);
    title.y = static_cast<int>(top);
    title.width = atlas.Width(graph.title);
    title.height = atlas.line_height();
    placed_.push_back(title);
    const float bar = graph_width / static_cast<float>(std::max<std::size_t>(graph.values.size(), 1));
    for (std::size_t i = 0; i < graph.values.size(); ++i) {
      const float share = std::clamp(graph.values[i] / graph.most, 0.0f, 1.0f);
      if (share <= 0.0f) continue;
      const float x = left + bar * static_cast<float>(i);
      AddPanel(x, bottom - share * bars_height, x + 0.9f * bar, bottom, glm::vec4(ToDisplay(graph.color), 0.9f));
    }
    top = bottom + 6 * unit;
  }
}

void TextPainter::AddPanel(float x0, float y0, float x1, float y1, const glm::vec4& c) {
  const auto vertex = [&](float x, float y) { batch_.push_back({x, y, -1.0f, -1.0f, c.r, c.g, c.b, c.a}); };
  for (const auto& [x, y] : {std::pair{x0, y0}, {x1, y0}, {x1, y1}, {x0, y0}, {x1, y1}, {x0, y1}}) vertex(x, y);
}

void TextPainter::AddLine(const PlacedLine& placed, const Font& font) {
  const GlyphAtlas& atlas = font.atlas;
  const glm::vec3 color =
      placed.line.style == view::TextStyle::kBadge ? glm::vec3(0.06f, 0.05f, 0.03f) : ToDisplay(placed.line.color);
  int pen = placed.x;
  for (const std::uint8_t c : GlyphAtlas::Characters(placed.line.text)) {
    const GlyphAtlas::Glyph& g = atlas.glyph(c);
    const auto vertex = [&](int i, int j) {
      batch_.push_back({static_cast<float>(pen + g.left + i), static_cast<float>(placed.y + atlas.ascent() - g.top + j),
                        static_cast<float>(g.x + i) / static_cast<float>(atlas.width()),
                        static_cast<float>(g.y + j) / static_cast<float>(atlas.height()), color.r, color.g, color.b,
                        1.0f});
    };
    const int w = g.width, h = g.height;
    for (const auto& [i, j] : {std::pair{0, 0}, {w, 0}, {w, h}, {0, 0}, {w, h}, {0, h}}) vertex(i, j);
    pen += g.advance;
  }
}

// A dark strip behind the caption, a filled one behind each badge and label, and one behind the lines of either upper
// corner.
void TextPainter::AddPanels(std::size_t num_lines, std::size_t num_labels, int width, int height) {
  const auto scale = static_cast<float>(height) / 360.0f;
  float caption_top = static_cast<float>(height);
  float table_left = static_cast<float>(width), table_top = static_cast<float>(height), table_end = 0.0f;
  float head_right = 0.0f, head_end = 0.0f;
  const auto add_behind = [&](const PlacedLine& item, float margin, const glm::vec4& color) {
    AddPanel(static_cast<float>(item.x) - margin * scale, static_cast<float>(item.y) - margin / 3 * scale,
             static_cast<float>(item.x + item.width) + margin * scale,
             static_cast<float>(item.y + item.height) + margin / 3 * scale, color);
  };
  for (std::size_t i = 0; i < num_lines; ++i) {
    const PlacedLine& item = placed_[i];
    if (item.line.anchor == view::Anchor::kBottomLeft) caption_top = std::min(caption_top, static_cast<float>(item.y));
    if (item.line.style == view::TextStyle::kBadge) {
      add_behind(item, 6.0f, glm::vec4(ToDisplay(item.line.color), 0.92f));
    } else if (item.line.anchor == view::Anchor::kTopLeft) {
      head_right = std::max(head_right, static_cast<float>(item.x + item.width));
      head_end = std::max(head_end, static_cast<float>(item.y + item.height));
    } else if (item.line.anchor == view::Anchor::kTopRight) {
      table_left = std::min(table_left, static_cast<float>(item.x));
      table_top = std::min(table_top, static_cast<float>(item.y));
      table_end = std::max(table_end, static_cast<float>(item.y + item.height));
    }
  }
  if (head_end > 0.0f) AddPanel(6 * scale, 8 * scale, head_right + 4 * scale, head_end + 2 * scale, kHeadBackground);
  if (table_end > 0.0f) {
    AddPanel(table_left - 4 * scale, table_top, static_cast<float>(width) - 6 * scale, table_end, kBackground);
  }
  for (std::size_t i = num_lines; i < num_lines + num_labels; ++i) add_behind(placed_[i], 4.0f, kBackground);
  if (caption_top >= static_cast<float>(height)) return;
  AddPanel(0, caption_top - 6 * scale, static_cast<float>(width), static_cast<float>(height),
           glm::vec4(0.02f, 0.03f, 0.05f, 0.72f));
  AddPanel(0, caption_top - 7 * scale, static_cast<float>(width), caption_top - 6 * scale,
           glm::vec4(0.35f, 0.75f, 0.95f, 0.55f));
}

core::Result<void> TextPainter::Draw(const Hud& hud, int width, int height) {
  const auto fonts = FontsFor(height);
  if (!fonts) return tl::unexpected(fonts.error());
  PlaceLines(hud.lines, width, height, **fonts);
  PlaceLabels(hud.labels, width, height, **fonts);

  // Panels first, then the lines, by font.
  batch_.clear();
  AddPanels(hud.lines.size(), hud.labels.size(), width, height);
  DrawGraphs(hud.graphs, width, height, **fonts);
  std::array<std::size_t, 5> first{};
  for (std::size_t style = 0; style < 4; ++style) {
    first[style] = batch_.size();
    for (const PlacedLine& item : placed_) {
      if (static_cast<std::size_t>(item.line.style) == style) AddLine(item, (**fonts)[style]);
    }
  }
  first[4] = batch_.size();
  if (batch_.empty()) return {};
  const std::size_t num_bytes = batch_.size() * sizeof(Vertex);
  if (num_bytes > capacity_bytes_) {
    vertices_ = MakeBuffer(nullptr, capacity_bytes_ = 2 * num_bytes);
    glVertexArrayVertexBuffer(layout_.id(), 0, vertices_.id(), 0, sizeof(Vertex));
  }
  glNamedBufferSubData(vertices_.id(), 0, static_cast<GLsizeiptr>(num_bytes), batch_.data());

  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glUseProgram(program_.id());
  glUniform2f(0, static_cast<float>(width), static_cast<float>(height));
  glBindVertexArray(layout_.id());
  if (first[0] > 0) glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(first[0]));
  for (std::size_t style = 0; style < 4; ++style) {
    if (first[style + 1] == first[style]) continue;
    glBindTextureUnit(0, (**fonts)[style].texture.id());
    glDrawArrays(GL_TRIANGLES, static_cast<GLint>(first[style]), static_cast<GLsizei>(first[style + 1] - first[style]));
  }
  glDisable(GL_BLEND);
  return {};
}

}  // namespace visual_node
