#pragma once

namespace tiles {

// A rectangle of a picture's pixels; y from the top.
struct Tile {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;

  [[nodiscard]] int num_pixels() const { return width * height; }
  bool operator==(const Tile&) const = default;
};

}  // namespace tiles
