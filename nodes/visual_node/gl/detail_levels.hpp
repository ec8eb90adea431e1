#pragma once

#include <atomic>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "vps/mesh/load_mesh.hpp"

namespace visual_node {

// One connected part of a mesh in less and less detail.
struct Piece {
  struct Level {
    // No vertex that the whole part has is farther from this level's surface.
    float error_m = 0.0f;
    // By primitive of the mesh, three for each triangle: indices of its vertices.
    std::vector<std::vector<std::uint32_t>> indices;
  };
  glm::vec3 centre_M{0.0f};  // of a sphere around it
  float radius_m = 0.0f;
  // The first is the whole part, and has no error; each next one has at most three quarters of the triangles, and the
  // last has none. By edge collapses that change the surface least [Garland and Heckbert 1997], and the lines at which
  // materials meet.
  std::vector<Level> levels;
};

// Adds to the mesh the vertices that levels need beside its own. Ends within a level when a stop is wanted, with what
// there is by then.
std::vector<Piece> MakePieces(vps::VisualMesh* mesh, const std::atomic<bool>* is_stop_wanted = nullptr);

}  // namespace visual_node
