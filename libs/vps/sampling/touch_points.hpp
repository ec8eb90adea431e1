#pragma once

#include <vector>

#include "vps/sampling/sample_tree.hpp"
#include "vps/surface/surface_tree.hpp"

namespace vps {

// Faces that turn more at an edge are two faces. Not derived; the edges of a finely tessellated round part (5.6 degrees
// for 64 segments) stay below it.
constexpr double kSharpAngle_deg = 25.0;

// A place at which a surface can touch another one first: somewhere on a flat patch, along a piece of a convex sharp
// edge, or at a corner of the mesh.
struct TouchPlace {
  enum class Kind : std::uint8_t { kFace, kEdge, kCorner };
  Kind kind = Kind::kCorner;
  std::uint8_t bin = 0;    // DirectionBin of `inward`
  glm::vec3 inward{0.0f};  // unit: the mean of the faces around it
  glm::vec3 along{0.0f};   // kEdge: unit
  float reach_m = 0.0f;    // of the patch or of the piece of edge about its point
  float cone_rad = 0.0f;   // largest angle between `inward` and that of a face around it
};

// Places of one block of the tree that have kind and bin in common.
struct TouchGroup {
  TouchPlace::Kind kind = TouchPlace::Kind::kCorner;
  std::uint8_t bin = 0;
  std::uint16_t lanes = 0;  // bits
};

// The same surface as the samples, as places in the order of a tree: place i belongs to point i of the tree. Samples
// lie within the surface, where a mean depth is taken best; these lie on it, and where it reaches out farthest.
struct TouchPoints {
  SampleTree tree;
  std::vector<TouchPlace> places;
  std::vector<TouchGroup> groups;          // in the order of blocks
  std::vector<std::uint32_t> group_begin;  // of each block, and the end
  const SurfaceTree* surface = nullptr;    // itself, which has to outlive this
  double spacing_m = 0.0;                  // of the samples
  double most_reach_m = 0.0;               // of all places
  double turn_rad = 0.0;                   // the most from face to face of a round part: where no edge is sharp
};

// From the samples of flat patches and from the triangles' sides and corners.
TouchPoints FindTouchPoints(const SampleTree& samples, const SurfaceTree& surface);

}  // namespace vps
