#pragma once

#include "vps/mesh/load_mesh.hpp"

namespace visual_node {

// Each edge belongs to as many triangles in one direction as in the other, and each part that hangs together encloses a
// positive volume: seen from outside, the triangles that face away are hidden by others and need not be drawn.
// Corners are the same where their coordinates are the same bits.
bool IsClosedAndFacesOutwards(const vps::VisualMesh& mesh);

}  // namespace visual_node
