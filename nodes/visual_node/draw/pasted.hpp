#pragma once

#include "tiles/pixels.hpp"
#include "tiles/tile.hpp"

namespace visual_node {

// Surfaces that somebody else has drawn: a rectangle of a picture, which may have several eyes' views.
struct Pasted {
  const tiles::Canvas* canvas = nullptr;
  tiles::Tile at;
};

}  // namespace visual_node
