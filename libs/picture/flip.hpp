#pragma once

#include <cstdint>
#include <vector>

#include "picture/image.hpp"
#include "picture/measured.hpp"

namespace picture {

// How different two pictures look when one is shown after the other at the same place: FLIP, after Andersson, Nilsson,
// Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference Evaluator for Alternating Images" (2020). For
// each pixel 0 (the same) to 1 (the greatest difference): colours as the eye resolves them from this distance, as a
// distance in a perceptually uniform space, made greater where edges and points differ.

// Pixels per degree of a person 0.7 m in front of a screen 0.7 m wide with 3840 pixels, as in the paper.
inline constexpr double kPixelsPerDegree = 67.0206432766;

// Both pictures have the same size. Alpha is not used.
Measured<float> Flip(const Image& reference, const Image& test, double pixels_per_degree = kPixelsPerDegree);

// The mean over all pixels, or over those where `mask` is not 0; 0 when there are none.
double Mean(const Measured<float>& map);
double Mean(const Measured<float>& map, const Measured<std::uint16_t>& mask);

}  // namespace picture
