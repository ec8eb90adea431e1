#pragma once

#include "vps/mesh/load_mesh.hpp"

namespace vps {

enum class Pictures { kSkip, kRead };

// Primitives of the file's default scene with node transforms applied; normals are empty where the file has none.
core::Result<VisualMesh> LoadGltfPrimitives(const std::filesystem::path& file, double scale, Pictures pictures);

}  // namespace vps
