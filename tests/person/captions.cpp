#include "tests/person/captions.hpp"

#include <utility>

namespace person_tests {
namespace {

constexpr int kLetters_px = 20;  // small letters in a window of 720 rows
constexpr int kMargin_px = 20;
constexpr int kLongestBlank = 4;  // characters within a line

}  // namespace

core::Result<CaptionReader> CaptionReader::Create() {
  auto atlas = picture::GlyphAtlas::Create(kLetters_px);
  if (!atlas) return tl::unexpected(atlas.error());
  return CaptionReader(std::move(*atlas));
}

int CaptionReader::Likeness(const GreyPicture& picture, int x, int y, unsigned char letter) const {
  const picture::GlyphAtlas::Glyph& glyph = atlas_.glyph(letter);
  int alike = 0, different = 0;
  for (int j = 0; j < atlas_.line_height(); ++j) {
    for (int i = 0; i < glyph.advance; ++i) {
      const int u = i - glyph.left, v = j - (atlas_.ascent() - glyph.top);
      const bool is_inside = u >= 0 && v >= 0 && u < glyph.width && v < glyph.height;
      const std::size_t at = static_cast<std::size_t>((glyph.y + v) * atlas_.width() + glyph.x + u);
      const int coverage = is_inside ? atlas_.coverage()[at] : 0;
      const bool is_bright = picture.IsBright(x + i, y + j);
      if (coverage > 64 && coverage < 192) continue;  // an edge: depends on what is behind
      alike += is_bright && coverage >= 192 ? 1 : 0;
      different += is_bright != (coverage >= 192) ? 1 : 0;
    }
  }
  return alike - 3 * different;
}

std::string CaptionReader::ReadLine(const GreyPicture& picture, int x, int y) const {
  std::string text;
  int num_blanks = 0;
  while (x < picture.width && num_blanks <= kLongestBlank) {
    unsigned char best = 0;
    int most = -1;
    for (unsigned char letter = ' '; letter < 127; ++letter) {
      if (letter == 'I' || letter == 'J') continue;  // too like l and j
      const int likeness = Likeness(picture, x, y, letter);
      if (likeness > most) {
        most = likeness;
        best = letter;
      }
    }
    if (best == 0) break;
    num_blanks = best == ' ' ? num_blanks + 1 : 0;
    text += static_cast<char>(best);
    x += atlas_.glyph(best).advance;
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

std::vector<std::string> CaptionReader::Read(const GreyPicture& picture) const {
  constexpr std::size_t kShortest = 4;
  std::vector<std::string> lines;
  for (int y = 0; y + atlas_.line_height() <= picture.height; ++y) {
    std::string line = ReadLine(picture, kMargin_px, y);
    if (line.size() < kShortest || line.starts_with(' ')) continue;
    lines.push_back(std::move(line));
    y += atlas_.line_height() - 1;
  }
  return lines;
}

}  // namespace person_tests
