#include "view/appearance/foil.hpp"

#include <cmath>
#include <cstdint>

#include "view/appearance/lattice_noise.hpp"

namespace view {
namespace {

constexpr float kBulge = 1.2f;  // from the middle of a facet to its edge, against its own tilt

// The facet to which a place belongs is that of the nearest of random points, one in each cell [Worley 1996].
glm::vec2 Tilt(glm::vec2 place, int num_cells, std::uint32_t layer) {
  const glm::ivec2 cell(glm::floor(place));
  float nearest = 1e9f;
  glm::vec2 tilt(0.0f);
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const int x = cell.x + dx, y = cell.y + dy;
      const int tile_x = (x + num_cells) % num_cells, tile_y = (y + num_cells) % num_cells;
      const glm::vec2 point(static_cast<float>(x) + 0.5f + 0.45f * LatticeNoise(tile_x, tile_y, layer),
                            static_cast<float>(y) + 0.5f + 0.45f * LatticeNoise(tile_x, tile_y, layer + 1));
      const float distance = glm::distance(point, place);
      if (distance >= nearest) continue;
      nearest = distance;
      tilt = glm::vec2(LatticeNoise(tile_x, tile_y, layer + 2), LatticeNoise(tile_x, tile_y, layer + 3)) +
             kBulge * (point - place);
    }
  }
  return tilt;
}

}  // namespace

// Sizes, tilts and bulge by eye: facets of 40 and 12 mm on a tile of 0.25 m.
std::vector<glm::vec3> FoilTilts() {
  constexpr int kCoarse = 6, kFine = 20;
  std::vector<glm::vec3> tilts;
  for (int y = 0; y < kFoilSize; ++y) {
    for (int x = 0; x < kFoilSize; ++x) {
      const glm::vec2 at = (glm::vec2(x, y) + 0.5f) / static_cast<float>(kFoilSize);
      const glm::vec2 tilt = 0.17f * Tilt(at * static_cast<float>(kCoarse), kCoarse, 1) +
                             0.15f * Tilt(at * static_cast<float>(kFine), kFine, 11);
      tilts.emplace_back(tilt, glm::dot(tilt, tilt));
    }
  }
  return tilts;
}

}  // namespace view
