#include "tiles/cost_map.hpp"

#include <algorithm>
#include <utility>

namespace tiles {

CostMap::CostMap() : pixel_s_(std::size_t{kColumns} * kRows, kGuess_s) {}

// visit(cell, pixels of the tile in it) for each cell that the tile reaches into.
template <class Visit>
void CostMap::EachCell(const Tile& tile, int width, int height, Visit&& visit) {
  const double cell_width = static_cast<double>(width) / kColumns, cell_height = static_cast<double>(height) / kRows;
  const auto overlap = [](double begin, double end, double cell, int i) {
    return std::max(std::min(end, (i + 1) * cell) - std::max(begin, i * cell), 0.0);
  };
  const auto first = [](int begin, double cell) { return std::max(static_cast<int>(begin / cell), 0); };
  for (int row = first(tile.y, cell_height); row < kRows && row * cell_height < tile.y + tile.height; ++row) {
    const double rows = overlap(tile.y, tile.y + tile.height, cell_height, row);
    for (int column = first(tile.x, cell_width); column < kColumns && column * cell_width < tile.x + tile.width;
         ++column) {
      const double columns = overlap(tile.x, tile.x + tile.width, cell_width, column);
      visit(static_cast<std::size_t>(row * kColumns + column), rows * columns, cell_width * cell_height);
    }
  }
}

void CostMap::Take(const Tile& tile, int width, int height, double cost_s) {
  if (tile.num_pixels() == 0) return;
  const double pixel_s = cost_s / tile.num_pixels();
  EachCell(tile, width, height, [&](std::size_t cell, double pixels, double all_pixels) {
    pixel_s_[cell] += std::min(pixels / all_pixels, 1.0) * (pixel_s - pixel_s_[cell]);
  });
}

double CostMap::Of(const Tile& tile, int width, int height) const {
  double cost_s = 0.0;
  EachCell(tile, width, height, [&](std::size_t cell, double pixels, double) { cost_s += pixels * pixel_s_[cell]; });
  return cost_s;
}

namespace {

// The first half of a side, in steps; the whole side when it is too short to be cut.
int HalfOf(int side) {
  return side < 2 * kLeastSide ? side : (side / 2 + kStep - 1) / kStep * kStep;
}

}  // namespace

std::vector<Tile> CutIntoTiles(const CostMap& costs, int width, int height, double most_s) {
  std::vector<std::pair<double, Tile>> cut;
  std::vector<Tile> open = {{0, 0, width, height}};
  while (!open.empty()) {
    const Tile tile = open.back();
    open.pop_back();
    const double cost_s = costs.Of(tile, width, height);
    Tile first = tile, second = tile;
    if (tile.width >= tile.height) {
      first.width = HalfOf(tile.width);
      second.x += first.width;
      second.width -= first.width;
    } else {
      first.height = HalfOf(tile.height);
      second.y += first.height;
      second.height -= first.height;
    }
    const bool is_small = cost_s <= most_s && tile.num_pixels() <= kMostPixels;
    if (is_small || second.num_pixels() == 0) {
      cut.emplace_back(cost_s, tile);
    } else {
      open.push_back(first);
      open.push_back(second);
    }
  }
  std::stable_sort(cut.begin(), cut.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Tile> tiles;
  for (const auto& [cost_s, tile] : cut) tiles.push_back(tile);
  return tiles;
}

}  // namespace tiles
