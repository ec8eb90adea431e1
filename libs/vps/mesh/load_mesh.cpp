#include "vps/mesh/load_mesh.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "vps/mesh/load_gltf.hpp"
#include "vps/mesh/load_openmesh.hpp"
#include "vps/mesh/vertex_normals.hpp"

namespace vps {
namespace {

enum class Format { kGltf, kOpenMesh };

core::Result<Format> FormatOf(const std::filesystem::path& file, double scale) {
  if (!(scale > 0.0) || !std::isfinite(scale)) {
    return core::Fail(core::ErrorCode::kInvalidInput, file.string() + ": scale must be positive");
  }
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    return core::Fail(core::ErrorCode::kNotFound, "mesh file '" + file.string() + "' does not exist or is not a file");
  }
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".gltf" || extension == ".glb") return Format::kGltf;
  for (const char* known : {".obj", ".stl", ".ply", ".off"}) {
    if (extension == known) return Format::kOpenMesh;
  }
  return core::Fail(core::ErrorCode::kUnsupported, file.string() + ": unknown mesh format '" + extension +
                                                       "'; known are .gltf .glb .obj .stl .ply .off");
}

void ForgetTextures(VisualMaterial* material) {
  material->base_texture = material->surface_texture = material->normal_texture = material->emissive_texture = -1;
  material->has_occlusion = false;
}

}  // namespace

core::Result<TriangleMesh> LoadTriangles(const std::filesystem::path& file, double scale) {
  const auto format = FormatOf(file, scale);
  if (!format) return tl::unexpected(format.error());
  TriangleMesh mesh;
  if (*format == Format::kGltf) {
    const auto visual = LoadGltfPrimitives(file, scale, Pictures::kSkip);
    if (!visual) return tl::unexpected(visual.error());
    for (const auto& primitive : visual->primitives) {
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (const auto& p : primitive.positions) mesh.vertices.emplace_back(p);
      for (std::size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
        mesh.triangles.push_back(
            {first + primitive.indices[i], first + primitive.indices[i + 1], first + primitive.indices[i + 2]});
      }
    }
    return mesh;
  }
  return LoadOpenMeshTriangles(file, scale);
}

core::Result<TriangleMesh> LoadMesh(const std::filesystem::path& file, double scale) {
  const auto loaded = LoadTriangles(file, scale);
  if (!loaded) return loaded;
  TriangleMesh mesh = *loaded;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const glm::dvec3& p = mesh.vertices[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      return core::Fail(core::ErrorCode::kInvalidInput, file.string() + ": vertex " + std::to_string(i) +
                                                            " is not a finite number; export the mesh again");
    }
  }
  mesh = MergeDuplicateVertices(mesh);
  if (mesh.triangles.empty()) {
    return core::Fail(core::ErrorCode::kInvalidInput, file.string() + ": holds no triangle with an area");
  }
  return mesh;
}

core::Result<VisualMesh> LoadVisualMesh(const std::filesystem::path& file, double scale, double crease_rad) {
  const auto format = FormatOf(file, scale);
  if (!format) return tl::unexpected(format.error());
  if (*format == Format::kOpenMesh) {
    const auto mesh = LoadMesh(file, scale);
    if (!mesh) return tl::unexpected(mesh.error());
    return VisualMesh{{SplitAtCreases(*mesh, crease_rad)}};
  }
  auto visual = LoadGltfPrimitives(file, scale, Pictures::kRead);
  if (!visual) return visual;
  if (visual->primitives.empty()) {
    return core::Fail(core::ErrorCode::kInvalidInput, file.string() + ": holds no triangle");
  }
  for (auto& primitive : visual->primitives) {
    if (!primitive.normals.empty()) continue;
    if (!primitive.joints.empty()) {
      return core::Fail(core::ErrorCode::kUnsupported,
                        file.string() + ": a primitive with a skin has no NORMAL; export it with normals");
    }
    TriangleMesh mesh;
    for (const auto& p : primitive.positions) mesh.vertices.emplace_back(p);
    for (std::size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
      mesh.triangles.push_back({primitive.indices[i], primitive.indices[i + 1], primitive.indices[i + 2]});
    }
    VisualPrimitive with_normals = SplitAtCreases(MergeDuplicateVertices(mesh), crease_rad);
    primitive.positions = std::move(with_normals.positions);
    primitive.normals = std::move(with_normals.normals);
    primitive.indices = std::move(with_normals.indices);
    primitive.uvs.clear();  // of the corners before they were split
    ForgetTextures(&primitive);
    for (VisualMaterial& variant : primitive.variants) ForgetTextures(&variant);
  }
  return visual;
}

}  // namespace vps
