#pragma once

#include <cstdint>

#include "picture/flip.hpp"
#include "picture/image.hpp"
#include "picture/measured.hpp"

namespace view {

// What a renderer made of a scene. Ids: index of the instance + 1; 0: nothing.
struct Rendering {
  picture::Image image;
  picture::Measured<std::uint16_t> ids;
};

struct Agreement {
  double same_ids = 0.0;         // share of all pixels
  double same_ids_inside = 0.0;  // of the pixels whose eight neighbours show the same object as they do in `reference`
  double flip = 0.0;             // mean over the pixels that show an object in either
};

// Both are of the same size.
Agreement Compare(const Rendering& reference, const Rendering& test);

}  // namespace view
