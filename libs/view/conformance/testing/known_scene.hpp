#pragma once

#include <filesystem>

#include "core/result.hpp"
#include "view/scene.hpp"
#include "vps/mesh/load_mesh.hpp"

namespace view {

// KnownBodies in the sun, each in another colour, with KnownCamera. Its meshes are not files: MeshOfBody makes the one
// that Assets::meshes names.
Scene KnownScene();
core::Result<vps::VisualMesh> MeshOfBody(const std::filesystem::path& name);

}  // namespace view
