#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "nodes/visual_node/gl/detail_levels.hpp"
#include "nodes/visual_node/gl/mesh_store.hpp"

namespace visual_node {

// The pieces of a mesh with their levels, as indices of its vertices in UploadVertices.
class MeshDetail {
 public:
  MeshDetail() = default;
  MeshDetail(const vps::VisualMesh& mesh, const std::vector<Piece>& pieces);

  [[nodiscard]] bool is_empty() const { return pieces_.empty(); }
  [[nodiscard]] std::size_t num_parts() const { return num_parts_; }

  // From where a mesh is seen, and how exact it has to be there.
  struct View {
    glm::mat4 clip_M{1.0f};
    // A level may be wrong by allowed_m, and by allowed_share of the distance along the view.
    float allowed_m = 0.0f;
    float allowed_share = 0.0f;
  };
  // Appends the triangles that the view needs, part by part. `ends`: of each part, where it ends in `indices`.
  void Pick(const View& view, std::vector<std::uint32_t>* indices, std::vector<std::size_t>* ends) const;

 private:
  struct Run {
    std::uint32_t first = 0, count = 0;
  };
  struct OnePiece {
    glm::vec3 centre_M{0.0f};
    float radius_m = 0.0f;
    std::uint32_t first_level = 0, num_levels = 0;
  };

  std::size_t num_parts_ = 0;
  std::vector<OnePiece> pieces_;
  std::vector<float> errors_m_;                // by level
  std::vector<Run> runs_;                      // num_parts_ for each level
  std::vector<std::uint32_t> indices_;         // of all runs
  mutable std::vector<std::uint32_t> chosen_;  // levels; as long as pieces_, kept for its memory
};

// Triangles of this picture, in a buffer of their own.
class PickedTriangles {
 public:
  struct Run {
    GLsizei num_indices = 0;
    std::uintptr_t first_byte = 0;
  };
  static PickedTriangles Create();

  void Clear();
  // The runs of the parts of a mesh.
  std::vector<Run> Add(const MeshDetail& detail, const MeshDetail::View& view);
  void Upload() const;  // after the last Add

  [[nodiscard]] const GlBuffer& buffer() const { return buffer_; }

 private:
  GlBuffer buffer_;
  std::vector<std::uint32_t> indices_;
  std::vector<std::size_t> ends_;
};

// A mesh that can be drawn in less detail: its levels, and their vertices with the triangles that are picked.
struct DetailedMesh {
  MeshDetail levels;
  GlBuffer vertices;
  GlVertexArray layout;
};

}  // namespace visual_node
