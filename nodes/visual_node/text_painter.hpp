#pragma once

#include <array>
#include <map>
#include <memory>
#include <vector>

#include "core/result.hpp"
#include "nodes/visual_node/gl_objects.hpp"
#include "picture/glyph_atlas.hpp"
#include "view/scene.hpp"

namespace visual_node {

using picture::GlyphAtlas;

// A line of text with its rectangle in pixels of the target.
struct PlacedLine {
  view::TextLine line;
  int x = 0, y = 0, width = 0, height = 0;
};

// Draws a scene's lines of text over the picture. The letter size is proportional to the height of the target.
class TextPainter {
 public:
  static core::Result<std::unique_ptr<TextPainter>> Create();

  // Draws into the bound framebuffer. Error: kNotFound for a missing font.
  core::Result<void> Draw(const std::vector<view::TextLine>& lines, int width, int height);

  // The lines of the last Draw with their places.
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

  core::Result<Fonts*> FontsFor(int height);
  void Place(const std::vector<view::TextLine>& lines, int width, int height, const Fonts& fonts);
  void AddPanel(float x0, float y0, float x1, float y1, const glm::vec4& color);
  void AddLine(const PlacedLine& placed, const Font& font);

  GlProgram program_;
  GlVertexArray layout_;
  GlBuffer vertices_;
  std::size_t capacity_bytes_ = 0;
  std::map<int, Fonts> fonts_;  // by height of the target
  std::vector<PlacedLine> placed_;
  std::vector<Vertex> batch_;
};

}  // namespace visual_node
