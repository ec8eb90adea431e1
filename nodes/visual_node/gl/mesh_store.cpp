#include "nodes/visual_node/gl/mesh_store.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "nodes/visual_node/gl/closed_mesh.hpp"
#include "view/appearance/material.hpp"
#include "vps/mesh/vertex_normals.hpp"

namespace visual_node {

namespace {

struct Vertex {
  glm::vec3 position_M;
  glm::vec3 normal_M;
  glm::vec2 uv{0.0f};
};

GpuMesh::Look LookOf(const vps::VisualMaterial& given) {
  GpuMesh::Look look;
  look.material = view::MaterialOf(given);
  look.is_lens = given.is_lens;
  look.is_two_sided = given.is_two_sided;
  look.base_texture = given.base_texture;
  look.surface_texture = given.surface_texture;
  look.normal_texture = given.normal_texture;
  look.emissive_texture = given.emissive_texture;
  look.has_occlusion = given.has_occlusion;
  return look;
}

std::vector<Vertex> VerticesOf(const vps::VisualMesh& mesh) {
  std::vector<Vertex> vertices;
  for (const vps::VisualPrimitive& primitive : mesh.primitives) {
    for (std::size_t i = 0; i < primitive.positions.size(); ++i) {
      vertices.push_back({primitive.positions[i], primitive.normals[i]});
      if (!primitive.uvs.empty()) vertices.back().uv = primitive.uvs[i];
    }
  }
  return vertices;
}

// Bounding box and sphere.
void Bound(const std::vector<Vertex>& vertices, GpuMesh* gpu) {
  if (vertices.empty()) return;
  glm::vec3 low = vertices.front().position_M;
  glm::vec3 high = low;
  for (const Vertex& vertex : vertices) {
    low = glm::min(low, vertex.position_M);
    high = glm::max(high, vertex.position_M);
  }
  gpu->centre_M = 0.5f * (low + high);
  gpu->half_size_m = 0.5f * (high - low);
  gpu->radius_m = 0.0f;
  for (const Vertex& vertex : vertices) {
    gpu->radius_m = std::max(gpu->radius_m, glm::distance(gpu->centre_M, vertex.position_M));
  }
}

}  // namespace

GlTexture UploadTexture(const std::vector<view::MipLevel>& levels, bool is_color) {
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &id);
  GlTexture texture(id);
  // Of colours OpenGL mixes the light, not the codes.
  glTextureStorage2D(id, static_cast<GLsizei>(levels.size()), is_color ? GL_SRGB8_ALPHA8 : GL_RGBA8,
                     levels.front().width, levels.front().height);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    glTextureSubImage2D(id, static_cast<GLint>(i), 0, 0, levels[i].width, levels[i].height, GL_RGBA, GL_UNSIGNED_BYTE,
                        levels[i].texels.data());
  }
  glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  return texture;
}

MeshData MeshData::Of(vps::VisualMesh mesh) {
  MeshData data;
  const auto& all = mesh.primitives;
  const bool has_two_sides = std::any_of(all.begin(), all.end(), [](const auto& one) { return one.is_two_sided; });
  data.is_closed = has_two_sides && IsClosedAndFacesOutwards(mesh);
  for (const vps::VisualTexture& picture : mesh.textures) data.textures.push_back(view::MipLevels(picture));
  data.mesh = std::move(mesh);
  return data;
}

GpuMesh Upload(const MeshData& data, bool bends) {
  const vps::VisualMesh& mesh = data.mesh;
  GpuMesh gpu;
  const std::vector<Vertex> vertices = VerticesOf(mesh);
  std::vector<std::uint32_t> indices;
  std::uint32_t first_vertex = 0;
  for (const vps::VisualPrimitive& primitive : mesh.primitives) {
    GpuMesh::Part part;
    static_cast<GpuMesh::Look&>(part) = LookOf(primitive);
    part.num_indices = static_cast<GLsizei>(primitive.indices.size());
    part.first_byte = indices.size() * sizeof(std::uint32_t);
    for (const vps::VisualMaterial& variant : primitive.variants) part.variants.push_back(LookOf(variant));
    gpu.has_lens = gpu.has_lens || part.is_lens;
    for (const std::uint32_t i : primitive.indices) indices.push_back(first_vertex + i);
    first_vertex += static_cast<std::uint32_t>(primitive.positions.size());
    gpu.parts.push_back(std::move(part));
  }
  gpu.variants = mesh.variants;
  for (std::size_t i = 0; i < data.textures.size(); ++i) {
    gpu.textures.push_back(UploadTexture(data.textures[i], mesh.textures[i].is_color));
  }
  // Triangles that face away are hidden by others of a closed mesh, whatever its file says.
  if (data.is_closed && !bends) {
    for (GpuMesh::Part& part : gpu.parts) {
      part.is_two_sided = false;
      for (GpuMesh::Look& variant : part.variants) variant.is_two_sided = false;
    }
  }
  gpu.num_indices = static_cast<GLsizei>(indices.size());
  gpu.vertices = MakeBuffer(vertices.data(), vertices.size() * sizeof(Vertex));
  gpu.indices = MakeBuffer(indices.data(), indices.size() * sizeof(std::uint32_t));
  if (bends) gpu.rest = MakeBuffer(vertices.data(), vertices.size() * sizeof(Vertex));
  gpu.layout = MakeLayout(gpu.vertices, bends ? gpu.rest : gpu.vertices, gpu.indices);
  Bound(vertices, &gpu);
  return gpu;
}

GlBuffer UploadVertices(const vps::VisualMesh& mesh) {
  const std::vector<Vertex> vertices = VerticesOf(mesh);
  return MakeBuffer(vertices.data(), vertices.size() * sizeof(Vertex));
}

GlVertexArray MakeLayout(const GlBuffer& vertices, const GlBuffer& rest, const GlBuffer& indices) {
  GlVertexArray made = MakeVertexArray();
  const GLuint layout = made.id();
  glVertexArrayVertexBuffer(layout, 0, vertices.id(), 0, sizeof(Vertex));
  glVertexArrayVertexBuffer(layout, 1, rest.id(), 0, sizeof(Vertex));
  glVertexArrayElementBuffer(layout, indices.id());
  const GLuint offsets[2] = {offsetof(Vertex, position_M), offsetof(Vertex, normal_M)};
  for (const GLuint attribute : {0u, 1u, 2u, 3u}) {
    glEnableVertexArrayAttrib(layout, attribute);
    glVertexArrayAttribFormat(layout, attribute, 3, GL_FLOAT, GL_FALSE, offsets[attribute % 2]);
    glVertexArrayAttribBinding(layout, attribute, attribute / 2);
  }
  glEnableVertexArrayAttrib(layout, 4);
  glVertexArrayAttribFormat(layout, 4, 2, GL_FLOAT, GL_FALSE, offsetof(Vertex, uv));
  glVertexArrayAttribBinding(layout, 4, 0);
  return made;
}

void UpdateVertices(const vps::VisualMesh& mesh, GpuMesh* gpu) {
  const std::vector<Vertex> vertices = VerticesOf(mesh);
  Bound(vertices, gpu);
  glNamedBufferSubData(gpu->vertices.id(), 0, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)),
                       vertices.data());
}

namespace {

// Closed frustum from a ring of radius 1 at z = 0 to a ring of the given radius at z = 1.
vps::VisualMesh MakeFrustum(std::uint32_t num_sides, double top_radius) {
  vps::TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 0, 1}};
  for (std::uint32_t i = 0; i < num_sides; ++i) {
    const double angle = 2.0 * std::acos(-1.0) * i / num_sides;
    mesh.vertices.emplace_back(std::cos(angle), std::sin(angle), 0.0);
    mesh.vertices.emplace_back(top_radius * std::cos(angle), top_radius * std::sin(angle), 1.0);
    const std::uint32_t a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % num_sides);
    mesh.triangles.push_back({a, b, b + 1});
    mesh.triangles.push_back({a, b + 1, a + 1});
    mesh.triangles.push_back({0, b, a});
    mesh.triangles.push_back({1, a + 1, b + 1});
  }
  return {{vps::SplitAtCreases(mesh, 0.8)}};
}

}  // namespace

vps::VisualMesh MakeCylinder(std::uint32_t num_sides) {
  return MakeFrustum(num_sides, 1.0);
}
vps::VisualMesh MakeCone(std::uint32_t num_sides) {
  return MakeFrustum(num_sides, 0.0);
}

}  // namespace visual_node
