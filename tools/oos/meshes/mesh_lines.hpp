#pragma once

#include <string>

#include "vps/asset/feature_size.hpp"
#include "vps/mesh/check_mesh.hpp"

namespace oos {

// What `cook` and `inspect` say of a mesh: size, triangles, and a line for each defect.
void PrintMesh(const std::string& file, const vps::MeshReport& report);

// Thinnest wall and narrowest gap, with places.
void PrintFeatures(const vps::FeatureSize& size);

// What voxels of this size show of them, with a warning where that is not enough.
void PrintLimits(const vps::FeatureSize& size, const vps::FeatureLimits& limits);

}  // namespace oos
