#pragma once

#include "vps/mesh/load_mesh.hpp"

namespace vps {

// Primitives of the file's default scene with node transforms applied; normals are empty where the file has none.
core::Result<VisualMesh> LoadGltfPrimitives(const std::filesystem::path& file, double scale);

}  // namespace vps
