#pragma once

#include "core/result.hpp"
#include "picture/image.hpp"

namespace visual_node {

// The Earth's surface: columns from 180 degrees west to 180 degrees east, rows from the north pole to the south pole.
struct Ground {
  picture::Image colors;  // of the land, sRGB; water is transparent
  picture::Image clouds;  // grey: linear, the share of the ground that they hide on a fair day
  picture::Image lights;  // of towns at night, grey: linear, 255 is the brightest town
};

// Pictures that are a part of the program (make_ground.py). Error: kDamaged.
core::Result<Ground> ReadGround();

}  // namespace visual_node
