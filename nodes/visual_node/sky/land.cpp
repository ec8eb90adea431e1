#include "nodes/visual_node/sky/land.hpp"

#include <cstddef>

// The map, one bit for each pixel, becomes part of the program.
// NOLINTBEGIN
asm(".pushsection .rodata\n"
    ".global vr_oos_land\n"
    "vr_oos_land:\n"
    ".incbin \"" VR_OOS_LAND
    "\"\n"
    ".byte 0\n"
    ".popsection\n");
extern "C" const std::uint8_t vr_oos_land[];
// NOLINTEND

namespace visual_node {

LandMap ReadLand() {
  LandMap map{1440, 720, {}};
  const std::size_t num_pixels = 1440 * 720;
  map.pixels.resize(num_pixels);
  for (std::size_t i = 0; i < num_pixels; ++i) map.pixels[i] = (vr_oos_land[i / 8] >> (7 - i % 8)) & 1 ? 255 : 0;
  return map;
}

}  // namespace visual_node
