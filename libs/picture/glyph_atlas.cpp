#include "picture/glyph_atlas.hpp"

#include <ft2build.h>
#include FT_FREETYPE_H

#include <memory>
#include <type_traits>

namespace picture {
namespace {

constexpr const char* kRegular = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
constexpr const char* kBold = "/usr/share/fonts/truetype/dejavu/DejaVuSans-Bold.ttf";

struct CloseLibrary {
  void operator()(FT_Library library) const { FT_Done_FreeType(library); }
};
struct CloseFace {
  void operator()(FT_Face face) const { FT_Done_Face(face); }
};
using Library = std::unique_ptr<std::remove_pointer_t<FT_Library>, CloseLibrary>;
using Face = std::unique_ptr<std::remove_pointer_t<FT_Face>, CloseFace>;

}  // namespace

core::Result<GlyphAtlas> GlyphAtlas::Create(int size_px, bool is_bold) {
  FT_Library raw_library = nullptr;
  if (FT_Init_FreeType(&raw_library) != 0) {
    return core::Fail(core::ErrorCode::kResource, "cannot start FreeType; is the memory exhausted?");
  }
  const Library library(raw_library);
  const char* file = is_bold ? kBold : kRegular;
  FT_Face raw_face = nullptr;
  if (FT_New_Face(raw_library, file, 0, &raw_face) != 0) {
    return core::Fail(core::ErrorCode::kNotFound,
                      std::string("cannot read the font ") + file + "; install it: apt-get install fonts-dejavu-core");
  }
  const Face face(raw_face);
  FT_Set_Pixel_Sizes(raw_face, 0, static_cast<FT_UInt>(size_px));

  GlyphAtlas atlas;
  atlas.ascent_ = static_cast<int>(raw_face->size->metrics.ascender >> 6);
  atlas.line_height_ = static_cast<int>(raw_face->size->metrics.height >> 6);
  int pen_x = 1, pen_y = 1, row_height = 0;
  for (unsigned c = 32; c < 256; ++c) {
    if (FT_Load_Char(raw_face, c, FT_LOAD_RENDER) != 0) continue;
    const FT_GlyphSlot slot = raw_face->glyph;
    const int w = static_cast<int>(slot->bitmap.width);
    const int h = static_cast<int>(slot->bitmap.rows);
    if (pen_x + w + 1 > atlas.width_) {
      pen_x = 1;
      pen_y += row_height + 1;
      row_height = 0;
    }
    row_height = std::max(row_height, h);
    atlas.height_ = std::max(atlas.height_, pen_y + h + 1);
    atlas.coverage_.resize(static_cast<std::size_t>(atlas.width_ * atlas.height_), 0);
    for (int y = 0; y < h; ++y) {
      const std::uint8_t* row = slot->bitmap.buffer + static_cast<std::ptrdiff_t>(y) * slot->bitmap.pitch;
      std::copy(row, row + w,
                atlas.coverage_.begin() + static_cast<std::ptrdiff_t>((pen_y + y) * atlas.width_ + pen_x));
    }
    atlas.glyphs_[c] = {
        pen_x, pen_y, w, h, slot->bitmap_left, slot->bitmap_top, static_cast<int>(slot->advance.x >> 6)};
    pen_x += w + 1;
  }
  return atlas;
}

std::vector<std::uint8_t> GlyphAtlas::Characters(std::string_view utf8) {
  std::vector<std::uint8_t> characters;
  for (std::size_t i = 0; i < utf8.size(); ++i) {
    const auto lead = static_cast<unsigned char>(utf8[i]);
    if (lead < 0x80) {
      characters.push_back(lead < 32 ? ' ' : lead);
    } else if ((lead == 0xc2 || lead == 0xc3) && i + 1 < utf8.size()) {
      characters.push_back(
          static_cast<std::uint8_t>(((lead & 3u) << 6) | (static_cast<unsigned char>(utf8[++i]) & 0x3fu)));
    } else if ((lead & 0xc0u) != 0x80u) {  // one '?' per character, not per continuation byte
      characters.push_back('?');
    }
  }
  return characters;
}

int GlyphAtlas::Width(std::string_view utf8) const {
  int width = 0;
  for (const std::uint8_t c : Characters(utf8)) width += glyphs_[c].advance;
  return width;
}

void GlyphAtlas::Draw(std::string_view utf8, int x, int y, const std::array<std::uint8_t, 3>& rgb, Image& image) const {
  for (const std::uint8_t c : Characters(utf8)) {
    const Glyph& g = glyphs_[c];
    for (int j = 0; j < g.height; ++j) {
      for (int i = 0; i < g.width; ++i) {
        const int px = x + g.left + i;
        const int py = y + ascent_ - g.top + j;
        if (px < 0 || py < 0 || px >= image.width || py >= image.height) continue;
        const int a = coverage_[static_cast<std::size_t>((g.y + j) * width_ + g.x + i)];
        std::uint8_t* pixel = image.Pixel(px, py);
        for (std::size_t k = 0; k < 3; ++k) {
          pixel[k] = static_cast<std::uint8_t>((pixel[k] * (255 - a) + rgb[k] * a + 127) / 255);
        }
      }
    }
    x += g.advance;
  }
}

}  // namespace picture
