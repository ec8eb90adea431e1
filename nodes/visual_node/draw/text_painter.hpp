#pragma once

#include <array>
#include <map>
#include <memory>
#include <vector>

#include "core/result.hpp"
#include "nodes/visual_node/draw/label_places.hpp"
#include "nodes/visual_node/gl/gl_objects.hpp"
#include "picture/glyph_atlas.hpp"
#include "view/frustum.hpp"
#include "view/scene.hpp"

namespace visual_node {

using picture::GlyphAtlas;

// A line of text with its rectangle in pixels of the target.
struct PlacedLine {
  view::TextLine line;
  int x = 0, y = 0, width = 0, height = 0;
};

// A scene's text, labels and graphs, with the labels' places in pixels from the top left corner.
struct Hud {
  struct PlacedLabel {
    const view::Label* label = nullptr;
    glm::dvec2 at_px{0.0};
    double clear_px = 0.0;
  };
  const std::vector<view::TextLine>& lines;
  std::vector<PlacedLabel> labels;
  const std::vector<view::Graph>& graphs;
  std::vector<Stroke> strokes = {};  // arrows and rings, which labels should not hide
  std::vector<Box> taken = {};       // what others write into the picture, which labels may not hide
};

// A scene's text as an eye sees it. Labels outside of the picture are left out.
Hud HudOf(const view::Scene& scene, const view::Frustum& eye, int width, int height);

// Draws a scene's text over the picture. The letter size is proportional to the height of the target.
class TextPainter {
 public:
  static core::Result<std::unique_ptr<TextPainter>> Create();

  // Draws into the bound framebuffer. Error: kNotFound for a missing font.
  core::Result<void> Draw(const Hud& hud, int width, int height);

  // What these lines take of a picture of this size.
  core::Result<std::vector<Box>> BlocksOf(const std::vector<view::TextLine>& lines, int width, int height);

  // The lines of the last Draw with their places, then its labels (long ones have several lines) and the graphs'
  // titles.
  [[nodiscard]] const std::vector<PlacedLine>& placed() const { return placed_; }

 private:
  struct Font {
    GlyphAtlas atlas;
    GlTexture texture;
  };
  struct Vertex {
    float x, y, u, v;
    float r, g, b, a;
  };
  using Fonts = std::array<Font, 4>;  // by TextStyle
  struct Blocks {                     // behind the lines of a corner; of no size: there are none
    Box head;
    Box table;
    Box caption;
  };
  struct LabelPanel {
    Box box;
    Stroke leader;
    glm::vec3 color{1.0f};
  };

  core::Result<Fonts*> FontsFor(int height);
  void PlaceLines(const std::vector<view::TextLine>& lines, int width, int height, const Fonts& fonts);
  [[nodiscard]] Blocks BlocksOf(std::size_t num_lines, int width, int height) const;
  void PlaceHudLabels(const Hud& hud, int width, int height, const Fonts& fonts);
  void DrawGraphs(const std::vector<view::Graph>& graphs, int width, int height, const Fonts& fonts);
  void AddPanels(std::size_t num_lines, int width, int height);
  void AddPanel(float x0, float y0, float x1, float y1, const glm::vec4& color);
  void AddStroke(const Stroke& stroke, float width, const glm::vec4& color);
  void AddLine(const PlacedLine& placed, const Font& font);

  GlProgram program_;
  GlVertexArray layout_;
  GlBuffer vertices_;
  std::size_t capacity_bytes_ = 0;
  std::map<int, Fonts> fonts_;  // by height of the target
  std::vector<PlacedLine> placed_;
  std::vector<LabelPanel> panels_;
  int right_end_ = 0;  // below the lines at the top right [px]
  std::vector<Vertex> batch_;
};

}  // namespace visual_node
