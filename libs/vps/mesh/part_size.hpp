#pragma once

#include <string>

#include "core/result.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// Range of a part's longest side; a mesh outside it was most likely drawn in another unit. Half the smallest and twice
// the largest part of PartSize.TakesAMillimetreAndTenMetres: not derived otherwise.
constexpr double kSmallestPart_m = 0.0005;
constexpr double kLargestPart_m = 20.0;

// Two parts of a pair differ in size by less than this: a part in millimetres read as metres is 1000 times too large.
// Not derived: the margin below 1000 is for parts that differ by themselves.
constexpr double kLargestSizeRatio = 300.0;

double LongestSide_m(const Box& box);

// Error: longest side out of range. Begins with `name` and gives the size found.
core::Result<void> CheckPartSize(const std::string& name, const Box& box);

// Error: one of the two is so much larger that their units differ.
core::Result<void> CheckSameUnit(const std::string& name_A, const Box& A, const std::string& name_B, const Box& B);

// "0.25 mm", three digits.
std::string Millimetres(double length_m);

}  // namespace vps
