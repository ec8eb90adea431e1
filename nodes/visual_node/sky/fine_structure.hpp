#pragma once

#include <cstdint>
#include <vector>

namespace visual_node {

// Noise in a cube of kFineSize points a side that repeats in each direction, x first: two bytes a point. The first is
// puffy, as fair-weather clouds are; the second varies evenly, as land does. Their means are 127.5.
constexpr int kFineSize = 64;
std::vector<std::uint8_t> FineStructure();

// Of such a cube with `size` points a side: one with half as many, each the mean of eight.
std::vector<std::uint8_t> HalveFine(const std::vector<std::uint8_t>& bytes, int size);

}  // namespace visual_node
