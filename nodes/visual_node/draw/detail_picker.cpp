#include "nodes/visual_node/draw/detail_picker.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace visual_node {
namespace {

constexpr std::uint32_t kOutside = std::numeric_limits<std::uint32_t>::max();

}  // namespace

MeshDetail::MeshDetail(const vps::VisualMesh& mesh, const std::vector<Piece>& pieces)
    : num_parts_(mesh.primitives.size()) {
  std::vector<std::uint32_t> first_vertices(1, 0u);
  for (const vps::VisualPrimitive& primitive : mesh.primitives) {
    first_vertices.push_back(first_vertices.back() + static_cast<std::uint32_t>(primitive.positions.size()));
  }
  for (const Piece& piece : pieces) {
    pieces_.push_back({piece.centre_M, piece.radius_m, static_cast<std::uint32_t>(errors_m_.size()),
                       static_cast<std::uint32_t>(piece.levels.size())});
    for (const Piece::Level& level : piece.levels) {
      errors_m_.push_back(level.error_m);
      for (std::size_t k = 0; k < num_parts_; ++k) {
        runs_.push_back(
            {static_cast<std::uint32_t>(indices_.size()), static_cast<std::uint32_t>(level.indices[k].size())});
        for (const std::uint32_t i : level.indices[k]) indices_.push_back(first_vertices[k] + i);
      }
    }
  }
}

void MeshDetail::Pick(const View& view, std::vector<std::uint32_t>* indices, std::vector<std::size_t>* ends) const {
  const glm::mat4 rows = glm::transpose(view.clip_M);
  std::array<glm::vec4, 4> sides{rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1], rows[3] - rows[1]};
  for (glm::vec4& side : sides) side /= glm::length(glm::vec3(side));
  chosen_.assign(pieces_.size(), kOutside);
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const OnePiece& piece = pieces_[i];
    const glm::vec4 centre(piece.centre_M, 1.0f);
    if (std::any_of(sides.begin(), sides.end(),
                    [&](const glm::vec4& side) { return glm::dot(side, centre) < -piece.radius_m; })) {
      continue;
    }
    const float along_m = std::max(0.0f, glm::dot(rows[3], centre) - piece.radius_m);
    const float allowed_m = view.allowed_m + view.allowed_share * along_m;
    std::uint32_t level = piece.first_level;
    while (level + 1 < piece.first_level + piece.num_levels && errors_m_[level + 1] <= allowed_m) ++level;
    chosen_[i] = level;
  }
  for (std::size_t k = 0; k < num_parts_; ++k) {
    for (const std::uint32_t level : chosen_) {
      if (level == kOutside) continue;
      const Run& run = runs_[level * num_parts_ + k];
      const auto first = indices_.begin() + run.first;
      indices->insert(indices->end(), first, first + run.count);
    }
    ends->push_back(indices->size());
  }
}

PickedTriangles PickedTriangles::Create() {
  PickedTriangles picked;
  GLuint id = 0;
  glCreateBuffers(1, &id);
  picked.buffer_ = GlBuffer(id);
  return picked;
}

void PickedTriangles::Clear() {
  indices_.clear();
}

std::vector<PickedTriangles::Run> PickedTriangles::Add(const MeshDetail& detail, const MeshDetail::View& view) {
  ends_.clear();
  std::size_t begin = indices_.size();
  detail.Pick(view, &indices_, &ends_);
  std::vector<Run> runs;
  for (const std::size_t end : ends_) {
    runs.push_back({static_cast<GLsizei>(end - begin), begin * sizeof(std::uint32_t)});
    begin = end;
  }
  return runs;
}

// The storage is replaced, so that nothing waits for the picture before.
void PickedTriangles::Upload() const {
  const std::size_t num_bytes = std::max<std::size_t>(1, indices_.size()) * sizeof(std::uint32_t);
  glNamedBufferData(buffer_.id(), static_cast<GLsizeiptr>(num_bytes), indices_.empty() ? nullptr : indices_.data(),
                    GL_STREAM_DRAW);
}

}  // namespace visual_node
