#pragma once

#include <cstdint>
#include <vector>

namespace visual_node {

// Land (255) and sea (0) of the Earth: columns from 180 degrees west to 180 degrees east, rows from the south pole to
// the north pole. Natural Earth's coasts (public domain), by make_land.py.
struct LandMap {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;
};

LandMap ReadLand();

}  // namespace visual_node
