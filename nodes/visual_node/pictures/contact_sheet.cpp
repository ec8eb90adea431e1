#include "nodes/visual_node/pictures/contact_sheet.hpp"

#include <algorithm>

#include "picture/glyph_atlas.hpp"

namespace visual_node {

void ContactSheet::Add(const std::string& name, const Image& picture) {
  const auto known = std::find_if(tiles_.begin(), tiles_.end(), [&](const Tile& tile) { return tile.name == name; });
  if (known != tiles_.end()) {
    known->picture = picture;
  } else {
    tiles_.push_back({name, picture});
  }
}

core::Result<Image> ContactSheet::Compose() const {
  constexpr int kGap_px = 8;
  if (tiles_.empty())
    return core::Fail(core::ErrorCode::kNotFound, "no picture was taken: the procedure entered no step");
  const auto font = picture::GlyphAtlas::Create(18, true);
  if (!font) return tl::unexpected(font.error());
  const int strip_px = font->line_height() + 8;
  int width = 0, height = 0;
  for (const Tile& tile : tiles_) {
    width = std::max(width, tile.picture.width);
    height = std::max(height, tile.picture.height);
  }
  const int count = static_cast<int>(tiles_.size());
  const int columns = std::min(kColumns, count);
  const int rows = (count + columns - 1) / columns;
  Image sheet(columns * (width + kGap_px) + kGap_px, rows * (height + strip_px + kGap_px) + kGap_px);
  for (std::size_t i = 0; i < sheet.rgba.size(); i += 4) {
    sheet.rgba[i] = 14;
    sheet.rgba[i + 1] = 18;
    sheet.rgba[i + 2] = 26;
    sheet.rgba[i + 3] = 255;
  }
  for (int i = 0; i < count; ++i) {
    const Tile& tile = tiles_[static_cast<std::size_t>(i)];
    const int x = kGap_px + (i % columns) * (width + kGap_px);
    const int y = kGap_px + (i / columns) * (height + strip_px + kGap_px);
    Paste(tile.picture, x, y, sheet);
    const std::string caption = std::to_string(i + 1).append("  ").append(tile.name);
    font->Draw(caption, x + 4, y + height + 4, {225, 232, 240}, sheet);
  }
  return sheet;
}

core::Result<void> ContactSheet::Write(const std::filesystem::path& file) const {
  const auto sheet = Compose();
  if (!sheet) return tl::unexpected(sheet.error());
  return WritePng(*sheet, file);
}

}  // namespace visual_node
