#include "nodes/visual_node/draw/text_painter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "nodes/visual_node/draw/shaders.hpp"

namespace visual_node {
namespace {

constexpr std::array<int, 4> kSizeAt360 = {10, 13, 18, 10};  // letter size [px] by TextStyle, at a height of 360 px
constexpr std::array<bool, 4> kIsBold = {false, false, true, true};

glm::vec3 ToDisplay(const glm::vec3& linear) {
  return glm::pow(linear, glm::vec3(1.0f / 2.2f));
}

// The words of a text in lines that are not wider than that, except for a word that is.
std::vector<std::string> Wrap(const std::string& text, int most_px, const GlyphAtlas& atlas) {
  std::vector<std::string> lines(1);
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const std::string longer = lines.back().empty() ? word : lines.back() + " " + word;
    if (lines.back().empty() || atlas.Width(longer) <= most_px) {
      lines.back() = longer;
    } else {
      lines.push_back(word);
    }
  }
  return lines;
}

std::vector<glm::dvec3> RingCorners(const view::RingArrow& ring) {
  constexpr int kPieces = 12;  // of the whole ring: what is left out of it is short
  const glm::dvec3 aside = std::abs(ring.axis_W.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
  const glm::dvec3 u_W = glm::normalize(glm::cross(ring.axis_W, aside)), v_W = glm::cross(ring.axis_W, u_W);
  std::vector<glm::dvec3> corners;
  for (int i = 0; i <= kPieces; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kPieces;
    corners.push_back(ring.p_WCentre + ring.radius_m * (std::cos(angle) * u_W + std::sin(angle) * v_W));
  }
  return corners;
}

constexpr int kLabelWidthAt360 = 170;  // [px], of a line of a label

constexpr glm::vec4 kBackground{0.02f, 0.03f, 0.05f, 0.62f};
constexpr glm::vec4 kHeadBackground{0.02f, 0.03f, 0.05f, 0.45f};  // these lines are always there

}  // namespace

Hud HudOf(const view::Scene& scene, const view::Frustum& eye, int width, int height) {
  Hud hud{scene.texts, {}, scene.graphs};
  const double focal_px = view::FocalLengths_px(eye, width, height).y;
  for (const view::Label& label : scene.labels) {
    const glm::dvec3 pixel = view::ProjectToPixel(eye, width, height, label.p_W);
    const bool is_inside = pixel.z > 0.0 && pixel.x >= 0.0 && pixel.x < width && pixel.y >= 0.0 && pixel.y < height;
    if (is_inside) hud.labels.push_back({&label, glm::dvec2(pixel), label.clear_m * focal_px / pixel.z});
  }
  if (hud.labels.empty()) return hud;
  const auto add = [&](const glm::dvec3& p_W, const glm::dvec3& q_W) {
    const glm::dvec3 p = view::ProjectToPixel(eye, width, height, p_W);
    const glm::dvec3 q = view::ProjectToPixel(eye, width, height, q_W);
    if (p.z > 0.0 && q.z > 0.0) hud.strokes.push_back({glm::dvec2(p), glm::dvec2(q)});
  };
  for (const view::Arrow& arrow : scene.arrows) add(arrow.p_WTail, arrow.p_WTail + arrow.vector_W);
  for (const view::RingArrow& ring : scene.rings) {
    const std::vector<glm::dvec3> corners = RingCorners(ring);
    for (std::size_t i = 1; i < corners.size(); ++i) add(corners[i - 1], corners[i]);
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

// A panel for each label, and its lines in it.
void TextPainter::PlaceHudLabels(const Hud& hud, int width, int height, const Fonts& fonts) {
  panels_.clear();
  const double unit = height / 360.0, margin = 4.0 * unit, gap = 8.0 * unit;
  const GlyphAtlas& atlas = fonts[static_cast<std::size_t>(view::TextStyle::kBody)].atlas;
  std::vector<std::vector<std::string>> lines;
  std::vector<WantedLabel> wanted;
  for (const Hud::PlacedLabel& label : hud.labels) {
    lines.push_back(Wrap(label.label->text, static_cast<int>(kLabelWidthAt360 * unit), atlas));
    int widest = 0;
    for (const std::string& line : lines.back()) widest = std::max(widest, atlas.Width(line));
    const glm::dvec2 size(widest, static_cast<int>(lines.back().size()) * atlas.line_height());
    wanted.push_back({label.at_px, size + 2.0 * glm::dvec2(margin, margin / 3.0), label.clear_px});
  }
  std::vector<Box> taken = hud.taken;
  const Blocks blocks = BlocksOf(hud.lines.size(), width, height);
  for (const Box& block : {blocks.head, blocks.table, blocks.caption}) taken.push_back(block);
  const std::vector<Box> boxes = PlaceLabels(wanted, hud.strokes, taken, glm::dvec2(width, height), gap);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const view::Label& label = *hud.labels[i].label;
    panels_.push_back({boxes[i], LeaderOf(boxes[i], wanted[i].at, gap), label.color});
    for (std::size_t k = 0; k < lines[i].size(); ++k) {
      PlacedLine item;
      item.line = {view::Anchor::kTopLeft, view::TextStyle::kBody, label.color, lines[i][k]};
      item.width = atlas.Width(item.line.text);
      item.height = atlas.line_height();
      item.x = static_cast<int>(boxes[i].low.x + 0.5 * (boxes[i].size().x - item.width));
      item.y = static_cast<int>(boxes[i].low.y + margin / 3.0) + static_cast<int>(k) * item.height;
      placed_.push_back(item);
    }
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

void TextPainter::AddStroke(const Stroke& stroke, float width, const glm::vec4& c) {
  const glm::vec2 from(stroke.from), to(stroke.to);
  if (from == to) return;
  const glm::vec2 way = glm::normalize(to - from), side = 0.5f * width * glm::vec2(-way.y, way.x);
  for (const glm::vec2& p : {from + side, to + side, to - side, from + side, to - side, from - side}) {
    batch_.push_back({p.x, p.y, -1.0f, -1.0f, c.r, c.g, c.b, c.a});
  }
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

core::Result<std::vector<Box>> TextPainter::BlocksOf(const std::vector<view::TextLine>& lines, int width, int height) {
  const auto fonts = FontsFor(height);
  if (!fonts) return tl::unexpected(fonts.error());
  PlaceLines(lines, width, height, **fonts);
  const Blocks blocks = BlocksOf(lines.size(), width, height);
  return std::vector<Box>{blocks.head, blocks.table, blocks.caption};
}

TextPainter::Blocks TextPainter::BlocksOf(std::size_t num_lines, int width, int height) const {
  const double scale = height / 360.0;
  Box head{glm::dvec2(6.0, 8.0) * scale, glm::dvec2(0.0)}, table{glm::dvec2(width, height), glm::dvec2(0.0)};
  double caption_top = height;
  for (std::size_t i = 0; i < num_lines; ++i) {
    const PlacedLine& item = placed_[i];
    const glm::dvec2 low(item.x, item.y), high = low + glm::dvec2(item.width, item.height);
    if (item.line.anchor == view::Anchor::kBottomLeft) caption_top = std::min(caption_top, low.y);
    if (item.line.style == view::TextStyle::kBadge) continue;
    if (item.line.anchor == view::Anchor::kTopLeft) {
      head.high = glm::max(head.high, high + glm::dvec2(4.0, 2.0) * scale);
    } else if (item.line.anchor == view::Anchor::kTopRight) {
      table.low = glm::min(table.low, low - glm::dvec2(4.0 * scale, 0.0));
      table.high = {width - 6.0 * scale, std::max(table.high.y, high.y)};
    }
  }
  Blocks blocks;
  if (head.high.y > 0.0) blocks.head = head;
  if (table.high.y > 0.0) blocks.table = table;
  if (caption_top < height) blocks.caption = {{0.0, caption_top - 6.0 * scale}, {width, height}};
  return blocks;
}

// A dark strip behind the caption, a filled one behind each badge and label, and one behind the lines of either upper
// corner.
void TextPainter::AddPanels(std::size_t num_lines, int width, int height) {
  const auto scale = static_cast<float>(height) / 360.0f;
  const auto add_box = [&](const Box& box, const glm::vec4& color) {
    const glm::vec2 low(box.low), high(box.high);
    if (high.x > low.x) AddPanel(low.x, low.y, high.x, high.y, color);
  };
  for (std::size_t i = 0; i < num_lines; ++i) {
    const PlacedLine& item = placed_[i];
    if (item.line.style != view::TextStyle::kBadge) continue;
    const glm::dvec2 low(item.x, item.y), high = low + glm::dvec2(item.width, item.height);
    const glm::dvec2 margin = glm::dvec2(6.0, 2.0) * static_cast<double>(scale);
    add_box({low - margin, high + margin}, glm::vec4(ToDisplay(item.line.color), 0.92f));
  }
  const Blocks blocks = BlocksOf(num_lines, width, height);
  add_box(blocks.head, kHeadBackground);
  add_box(blocks.table, kBackground);
  for (const LabelPanel& label : panels_) {
    AddStroke(label.leader, 1.5f * scale, glm::vec4(ToDisplay(label.color), 0.8f));
    add_box(label.box, kBackground);
  }
  add_box(blocks.caption, glm::vec4(0.02f, 0.03f, 0.05f, 0.72f));
  const Box edge{blocks.caption.low - glm::dvec2(0.0, scale), {blocks.caption.high.x, blocks.caption.low.y}};
  add_box(edge, glm::vec4(0.35f, 0.75f, 0.95f, 0.55f));
}

core::Result<void> TextPainter::Draw(const Hud& hud, int width, int height) {
  const auto fonts = FontsFor(height);
  if (!fonts) return tl::unexpected(fonts.error());
  PlaceLines(hud.lines, width, height, **fonts);
  PlaceHudLabels(hud, width, height, **fonts);

  // Panels first, then the lines, by font.
  batch_.clear();
  AddPanels(hud.lines.size(), width, height);
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
