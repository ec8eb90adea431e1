#include "view/appearance/foil.hpp"

#include <cmath>
#include <cstdint>

#include "view/appearance/lattice_noise.hpp"

namespace view {
namespace {

constexpr float kBulge = 1.2f;  // from the middle of a facet to its edge, against its own tilt

// Of a cell, in units of cells.
struct Facet {
  glm::vec2 middle;  // from the cell's middle
  glm::vec2 tilt;
};

// The facets of a tile that repeats, row by row. Every process that draws makes the foil at its start, so each facet's
// noise is asked for once.
std::vector<Facet> Facets(int num_cells, std::uint32_t layer) {
  std::vector<Facet> facets;
  for (int y = 0; y < num_cells; ++y) {
    for (int x = 0; x < num_cells; ++x) {
      const auto noise = [&](std::uint32_t which) { return LatticeNoise(x, y, layer + which); };
      facets.push_back({0.45f * glm::vec2(noise(0), noise(1)), glm::vec2(noise(2), noise(3))});
    }
  }
  return facets;
}

// The facet to which a place belongs is that of the nearest of random points, one in each cell [Worley 1996].
glm::vec2 Tilt(const std::vector<Facet>& facets, int num_cells, glm::vec2 place) {
  const glm::ivec2 cell(glm::floor(place));
  float nearest = 1e9f;
  glm::vec2 tilt(0.0f);
  for (int y = cell.y - 1; y <= cell.y + 1; ++y) {
    for (int x = cell.x - 1; x <= cell.x + 1; ++x) {
      const int tile_x = (x + num_cells) % num_cells, tile_y = (y + num_cells) % num_cells;
      const Facet& facet = facets[static_cast<std::size_t>(tile_y * num_cells + tile_x)];
      const glm::vec2 away = glm::vec2(x, y) + 0.5f + facet.middle - place;
      const float distance = glm::dot(away, away);
      if (distance >= nearest) continue;
      nearest = distance;
      tilt = facet.tilt + kBulge * away;
    }
  }
  return tilt;
}

}  // namespace

// Sizes, tilts and bulge by eye: facets of 40 and 12 mm on a tile of 0.25 m.
std::vector<glm::vec3> FoilTilts() {
  constexpr int kCoarse = 6, kFine = 20;
  const std::vector<Facet> coarse = Facets(kCoarse, 1), fine = Facets(kFine, 11);
  std::vector<glm::vec3> tilts;
  tilts.reserve(static_cast<std::size_t>(kFoilSize) * kFoilSize);
  for (int y = 0; y < kFoilSize; ++y) {
    for (int x = 0; x < kFoilSize; ++x) {
      const glm::vec2 at = (glm::vec2(x, y) + 0.5f) / static_cast<float>(kFoilSize);
      const glm::vec2 tilt = 0.17f * Tilt(coarse, kCoarse, at * static_cast<float>(kCoarse)) +
                             0.15f * Tilt(fine, kFine, at * static_cast<float>(kFine));
      tilts.emplace_back(tilt, glm::dot(tilt, tilt));
    }
  }
  return tilts;
}

}  // namespace view
