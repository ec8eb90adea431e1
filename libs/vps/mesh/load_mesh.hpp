#pragma once

#include <filesystem>
#include <vector>

#include "core/result.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// Triangles of the file as they stand, in its order; positions times `scale`. Polygons are split into fans. Errors:
// file missing, unknown or damaged format.
core::Result<TriangleMesh> LoadTriangles(const std::filesystem::path& file, double scale = 1.0);

// Reads .gltf/.glb (node transforms applied) with tinygltf, .obj/.stl/.ply/.off with OpenMesh; positions times `scale`.
// Polygons are split into fans, duplicate vertices merged. Errors: file missing, unknown or damaged format,
// no triangles, a vertex that is not finite. Texture pictures are not read.
core::Result<TriangleMesh> LoadMesh(const std::filesystem::path& file, double scale = 1.0);

// A texture's picture, row by row from the top: red, green, blue, alpha, as the file has them.
struct VisualTexture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;
  bool is_color = false;  // sRGB; else the numbers are linear
};

// Triangles of one material, for drawing. Corners at creases are split, so positions and normals have one index.
struct VisualPrimitive {
  std::vector<glm::vec3> positions;  // m, mesh frame
  std::vector<glm::vec3> normals;    // unit, outwards
  std::vector<glm::vec2> uvs;        // of the textures, v downwards; none or one for each position
  std::vector<std::uint32_t> indices;
  glm::vec3 base_color{0.8f};  // linear RGB
  float metallic = 0.0f;
  float roughness = 0.6f;
  bool has_material = false;  // the file named one
  bool is_foil = false;       // the material's name begins with "mli" (multi-layer insulation)
  bool is_two_sided = true;   // false: its back is never seen, by the glTF material
  bool is_lens = false;       // the material's name begins with "lens": what shines of a lamp
  // Indices into VisualMesh::textures, each multiplied with the figure above; -1: none.
  int base_texture = -1;
  int surface_texture = -1;  // green: roughness, blue: metallic
  int normal_texture = -1;   // in tangent space
  // Red of the surface texture: the share of the surroundings' light that reaches the surface.
  bool has_occlusion = false;
};

struct VisualMesh {
  std::vector<VisualPrimitive> primitives;
  std::vector<VisualTexture> textures = {};
};

// As LoadMesh, with the normals, materials and textures of a glTF file. Where the file has no normals they are
// computed, smooth where neighbouring faces meet at less than `crease_rad` (area-weighted mean) and sharp elsewhere.
core::Result<VisualMesh> LoadVisualMesh(const std::filesystem::path& file, double scale = 1.0, double crease_rad = 0.6);

}  // namespace vps
