#pragma once

#include <cstdint>
#include <vector>

namespace visual_node {

// Noise in a cube of kFineSize points a side that repeats in each direction, x first: two bytes a point. The first is
// puffy, as fair-weather clouds are; the second varies evenly, as land does. Their means are 127.5.
constexpr int kFineSize = 64;
std::vector<std::uint8_t> FineStructure();

}  // namespace visual_node
