#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/pose.hpp"
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

// What a surface is made of: a glTF material.
struct VisualMaterial {
  glm::vec3 base_color{0.8f};  // linear RGB
  float metallic = 0.0f;
  float roughness = 0.6f;
  glm::vec3 emissive{0.0f};     // light of its own; 1: as bright as a white wall that faces the sun
  float coat = 0.0f;            // the share that clear lacquer or glass covers
  float coat_roughness = 0.0f;  // of the lacquer
  bool has_material = false;    // the file named one
  bool is_foil = false;         // the material's name begins with "mli" (multi-layer insulation)
  bool is_two_sided = true;     // false: its back is never seen
  bool is_lens = false;         // the material's name begins with "lens": what shines of a lamp
  // Of light that is not mirrored, the share that goes through (KHR_materials_transmission), and how strongly it is
  // bent (KHR_materials_ior). Only rays that are followed show it.
  float transmission = 0.0f;
  float ior = 1.5f;
  // Indices into VisualMesh::textures, each multiplied with the figure above; -1: none.
  int base_texture = -1;
  int surface_texture = -1;   // green: roughness, blue: metallic
  int normal_texture = -1;    // in tangent space
  int emissive_texture = -1;  // sRGB
  // Red of the surface texture: the share of the surroundings' light that reaches the surface.
  bool has_occlusion = false;
};

// Triangles of one material, for drawing. Corners at creases are split, so positions and normals have one index.
struct VisualPrimitive : VisualMaterial {
  std::vector<glm::vec3> positions;  // m, mesh frame
  std::vector<glm::vec3> normals;    // unit, outwards
  std::vector<glm::vec2> uvs;        // of the textures, v downwards; none or one for each position
  std::vector<std::uint32_t> indices;
  std::vector<VisualMaterial> variants;  // one for each of VisualMesh::variants, or none
  // Of a skin, for each position: indices into VisualMesh::joints and their shares, whose sum is 1.
  std::vector<glm::u16vec4> joints;
  std::vector<glm::vec4> weights;
};

// A joint of a skin (view/appearance/skin.hpp). At first the skin lies as its positions say.
struct VisualJoint {
  std::string name;
  core::Pose X_MJ;      // as the file places it
  core::Pose X_JMBind;  // the mesh frame seen from the joint for which the positions were made
};

struct VisualMesh {
  std::vector<VisualPrimitive> primitives;
  std::vector<VisualTexture> textures = {};
  std::vector<std::string> variants = {};  // names of looks that the file has beside its first one
  std::vector<VisualJoint> joints = {};    // none: rigid
};

// As LoadMesh, with the normals, materials, textures and skins of a glTF file. Where the file has no normals they are
// computed, smooth where neighbouring faces meet at less than `crease_rad` (area-weighted mean) and sharp elsewhere.
core::Result<VisualMesh> LoadVisualMesh(const std::filesystem::path& file, double scale = 1.0, double crease_rad = 0.6);

}  // namespace vps
