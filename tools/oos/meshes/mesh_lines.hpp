#pragma once

#include <string>

#include "vps/asset/feature_size.hpp"
#include "vps/mesh/check_mesh.hpp"

namespace oos {

// Prints a mesh's size, its number of triangles, and a line for each defect.
void PrintMesh(const std::string& file, const vps::MeshReport& report);

// Prints the thinnest wall and the narrowest gap, with their places.
void PrintFeatures(const vps::FeatureSize& size);

// Prints the walls and gaps that voxels of this size resolve, with a warning where that is not enough.
void PrintLimits(const vps::FeatureSize& size, const vps::FeatureLimits& limits);

}  // namespace oos
