#pragma once

#include <string>
#include <vector>

#include "nodes/visual_node/gl/gl_objects.hpp"
#include "view/appearance/mip_levels.hpp"
#include "view/scene.hpp"
#include "vps/mesh/load_mesh.hpp"

namespace visual_node {

// A mesh on the GPU, with its bounding box and bounding sphere.
struct GpuMesh {
  struct Look {
    view::Material material;
    bool is_lens = false;      // what shines of a lamp
    bool is_two_sided = true;  // false: its triangles that face away are not seen
    // Indices into `textures`; -1: none.
    int base_texture = -1;
    int surface_texture = -1;
    int normal_texture = -1;
    int emissive_texture = -1;
    bool has_occlusion = false;
  };
  struct Part : Look {  // a run of indices with one material
    GLsizei num_indices = 0;
    std::uintptr_t first_byte = 0;
    std::vector<Look> variants;  // one for each of GpuMesh::variants, or none

    // Its look in that variant; -1: the first.
    [[nodiscard]] const Look& look(int variant) const {
      return variant < 0 || variants.empty() ? *this : variants[static_cast<std::size_t>(variant)];
    }
  };

  GlVertexArray layout;
  GlBuffer vertices;
  GlBuffer rest;  // of a mesh that bends: its vertices before
  GlBuffer indices;
  std::vector<Part> parts;
  std::vector<GlTexture> textures;
  std::vector<std::string> variants;
  bool has_lens = false;
  GLsizei num_indices = 0;
  glm::vec3 centre_M{0.0f};  // of box and sphere
  glm::vec3 half_size_m{0.0f};
  float radius_m = 0.0f;
};

// The levels are given, because a software renderer takes long to make them.
GlTexture UploadTexture(const std::vector<view::MipLevel>& levels, bool is_color);

// What takes long before an upload, and no OpenGL.
struct MeshData {
  vps::VisualMesh mesh;
  bool is_closed = false;                             // and its triangles face outwards
  std::vector<std::vector<view::MipLevel>> textures;  // as mesh.textures

  static MeshData Of(vps::VisualMesh mesh);
};

// `bends`: UpdateVertices will be called, and the vertices of now are kept as those at rest.
GpuMesh Upload(const MeshData& data, bool bends = false);
inline GpuMesh Upload(const vps::VisualMesh& mesh, bool bends = false) {
  return Upload(MeshData::Of(mesh), bends);
}

// The vertices of all primitives, one after the other.
GlBuffer UploadVertices(const vps::VisualMesh& mesh);
// Such vertices as shaders read them, with triangles from `indices`. `rest`: of a mesh that bends, else the same.
GlVertexArray MakeLayout(const GlBuffer& vertices, const GlBuffer& rest, const GlBuffer& indices);

// Replaces positions and normals; the number of vertices must be the same.
void UpdateVertices(const vps::VisualMesh& mesh, GpuMesh* gpu);

// Shaft and head of an arrow, along +z from 0 to 1, radius 1.
vps::VisualMesh MakeCylinder(std::uint32_t num_sides);
vps::VisualMesh MakeCone(std::uint32_t num_sides);

}  // namespace visual_node
