#pragma once

#include <filesystem>

#include "core/result.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// Triangles of an OBJ, STL, PLY or OFF file as they stand, polygons split into fans.
core::Result<TriangleMesh> LoadOpenMeshTriangles(const std::filesystem::path& file, double scale);

}  // namespace vps
