#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "picture/image.hpp"

namespace picture {

// DejaVu Sans (Debian package fonts-dejavu-core) rasterised at one size: Latin-1, one coverage byte per pixel.
class GlyphAtlas {
 public:
  struct Glyph {
    int x = 0, y = 0, width = 0, height = 0;  // in the atlas
    int left = 0, top = 0;                    // from the pen to the glyph's corner; top is up from the base line
    int advance = 0;
  };

  // Errors: kNotFound without the font's file, kResource when FreeType does not start.
  static core::Result<GlyphAtlas> Create(int size_px, bool is_bold = false);

  // The Latin-1 characters of a UTF-8 text; control characters become blanks, characters beyond Latin-1 '?'.
  [[nodiscard]] static std::vector<std::uint8_t> Characters(std::string_view utf8);
  // Advance of the whole text [px].
  [[nodiscard]] int Width(std::string_view utf8) const;
  [[nodiscard]] int line_height() const { return line_height_; }
  [[nodiscard]] int ascent() const { return ascent_; }
  [[nodiscard]] const Glyph& glyph(std::uint8_t character) const { return glyphs_[character]; }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] const std::vector<std::uint8_t>& coverage() const { return coverage_; }

  // Blends the text over a picture, the line's top left corner at (x, y) [px]; pixels outside are clipped.
  void Draw(std::string_view utf8, int x, int y, const std::array<std::uint8_t, 3>& rgb, Image& image) const;

 private:
  std::array<Glyph, 256> glyphs_{};
  std::vector<std::uint8_t> coverage_;
  int width_ = 512;
  int height_ = 0;
  int line_height_ = 0;
  int ascent_ = 0;
};

}  // namespace picture
