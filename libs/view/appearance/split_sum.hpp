#pragma once

#include <glm/glm.hpp>
#include <vector>

namespace view {

// Of white light from everywhere, the share that a rough surface mirrors once towards a viewer at angle acos(nv) is
// F0 * x + y: the split sum [Karis 2013], for the distribution and the visibility of the surface shader. What it lacks
// to 1 for F0 = 1 has been reflected more than once; the shader gives it back [Fdez-Aguera 2019].
glm::vec2 SplitSum(double nv, double roughness);

// SplitSum for kSplitSumSize values of nv from 0 to 1 in a row, by as many rows of roughness from 0 to 1.
constexpr int kSplitSumSize = 32;
std::vector<glm::vec2> SplitSumTable();

}  // namespace view
