#pragma once

#include <cstdint>

namespace tiles {

// Which mirror images a picture has. kHalf: one ray for two by two pixels that show the same surface.
enum class Mirrors : std::uint8_t { kNone = 0, kHalf = 1, kAll = 2 };

// How a picture is drawn. Sample 0: through the pixels' centres, with hard shadows. From 1 on each sample looks through
// another place of the pixel, to another place of the sun, and in another direction for what hides the surroundings;
// the mean over many is the picture.
struct Quality {
  Mirrors mirrors = Mirrors::kAll;
  std::uint32_t sample = 0;
};

}  // namespace tiles
