#pragma once

#include <string>
#include <vector>

#include "core/result.hpp"
#include "picture/glyph_atlas.hpp"

namespace person_tests {

// Brightness of each pixel, rows from the top.
struct GreyPicture {
  int width = 0, height = 0;
  std::vector<unsigned char> values;
  [[nodiscard]] bool IsBright(int x, int y) const {
    constexpr int kBright = 130;  // letters are 190 and more, the dark strip behind them is 90 at most
    if (x < 0 || y < 0 || x >= width || y >= height) return false;
    return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] >
           kBright;
  }
};

// Reads the small lines at the bottom left of a viewer's window of 720 rows.
class CaptionReader {
 public:
  static core::Result<CaptionReader> Create();
  // The lines, from the top.
  [[nodiscard]] std::vector<std::string> Read(const GreyPicture& picture) const;

 private:
  explicit CaptionReader(picture::GlyphAtlas atlas) : atlas_(std::move(atlas)) {}
  // The text that begins there; empty: none. Letters that no glyph is like end it.
  [[nodiscard]] std::string ReadLine(const GreyPicture& picture, int x, int y) const;
  // How alike: pixels of the letter that are bright, less what differs in its cell.
  [[nodiscard]] int Likeness(const GreyPicture& picture, int x, int y, unsigned char letter) const;

  picture::GlyphAtlas atlas_;
};

}  // namespace person_tests
