#pragma once

#include <cstdint>
#include <vector>

#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

struct Orientation {
  std::size_t num_parts = 0;  // triangles connected by edges that two triangles share
  std::size_t num_parts_turned = 0;
  std::vector<std::uint32_t> turned;       // triangles turned over, ascending
  std::vector<std::uint32_t> conflicting;  // triangles at an edge that cannot be made consistent (a Moebius strip)
};

// Turns triangles over so that neighbours agree and solids face outwards. Within a part the side that most of its area
// shows wins. A part that lies in no other is turned when its volume (about the middle of its box) is negative; parts
// in it (cavities) turn with it. A part that encloses next to nothing keeps its side.
Orientation OrientParts(TriangleMesh* mesh);

}  // namespace vps
