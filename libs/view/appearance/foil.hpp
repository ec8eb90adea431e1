#pragma once

#include <glm/glm.hpp>
#include <vector>

namespace view {

// The wrinkles of multi-layer insulation: facets of two sizes, as crumpled foil has, each a little bulged. kFoilSize x
// kFoilSize tilts of the normal along x and y, and the sum of their squares, of which the means over larger areas say
// how much the foil varies within them. The tile repeats.
constexpr int kFoilSize = 256;
std::vector<glm::vec3> FoilTilts();

}  // namespace view
