#pragma once

#include <string>

#include "core/result.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// Longest side of the box around a part that a hand can have to do with. A mesh outside was most likely drawn in
// another unit.
constexpr double kSmallestPart_m = 0.0005;
constexpr double kLargestPart_m = 20.0;

// Two parts that meet each other differ in size by less than this: a part in millimetres read as metres is 1000 times
// too large.
constexpr double kLargestSizeRatio = 300.0;

double LongestSide_m(const Box& box);

// Error: longest side out of range. Begins with `name` and gives the size found.
core::Result<void> CheckPartSize(const std::string& name, const Box& box);

// Error: one of the two is so much larger that their units differ.
core::Result<void> CheckSameUnit(const std::string& name_A, const Box& A, const std::string& name_B, const Box& B);

}  // namespace vps
