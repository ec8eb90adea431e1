#pragma once

#include <vector>

#include "tiles/tile.hpp"

namespace tiles {

// How long the pixels of a picture take to draw: what was measured last, by place. Independent of the picture's size.
class CostMap {
 public:
  CostMap();

  // A tile of a picture of that size took so long.
  void Take(const Tile& tile, int width, int height, double cost_s);
  // How long a tile is expected to take [s].
  [[nodiscard]] double Of(const Tile& tile, int width, int height) const;

 private:
  // About 32 pixels of a picture of 1280x720: no more than the smallest tiles, so that the map has what they measured.
  static constexpr int kColumns = 40, kRows = 24;
  // Before anything is measured; the first frame's tiles are as large as they may be, so it hardly matters.
  static constexpr double kGuess_s = 1e-7;

  template <class Visit>
  static void EachCell(const Tile& tile, int width, int height, Visit&& visit);

  std::vector<double> pixel_s_;
};

// Cuts a picture into tiles that are expected to take `most_s` or less each, and are not larger than a message may be;
// the dearest first. Sides are multiples of kStep but at the picture's right and lower end.
std::vector<Tile> CutIntoTiles(const CostMap& costs, int width, int height, double most_s);

constexpr int kStep = 8;
constexpr int kMostPixels = 8192;  // 48 KiB of light and depths: a value of a STATE topic has 64 KiB at most
constexpr int kLeastSide = 16;     // below it the messages cost more than they spread

}  // namespace tiles
