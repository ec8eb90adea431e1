#pragma once

#include <cstdint>

#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// Parts with the features that contact is hard on: closed meshes with outward normals that do not meet themselves,
// lengths in m. For tests and benchmarks. The origin is inside or, for hollow parts, in the middle.

// Every edge cut at 45 degrees, every corner a triangle.
TriangleMesh MakeBevelledBlock(const glm::dvec3& size_m, double bevel_m);

// Axis z. A trapezoidal thread: of a pitch's length a quarter each is crest, flank, root, flank.
struct Thread {
  double radius_m = 0.0;  // of the crest
  double depth_m = 0.0;   // from crest to root
  double pitch_m = 0.0;
  int num_turns = 0;
  int num_segments = 0;  // of a turn, and rows of a pitch; a multiple of 4, so that crest and root end at vertices
};
TriangleMesh MakeThreadedRod(const Thread& thread);

TriangleMesh MakeTube(double outer_radius_m, double inner_radius_m, double length_m, int num_segments);  // axis z

// A box of outer size `size_m`, open at +z, walls and floor `wall_m` thick.
TriangleMesh MakeTray(const glm::dvec3& size_m, double wall_m);

// Along y. Narrows towards +z from `width_m` to `edge_width_m`; 0: a sharp edge.
TriangleMesh MakeWedge(double length_m, double width_m, double height_m, double edge_width_m);

// Along z, a rod whose last part narrows to a flat tip at +z.
TriangleMesh MakeNeedle(double radius_m, double length_m, double taper_length_m, double tip_radius_m, int num_segments);

// A sheet bent around an axis along y: `length_m` along the arc, and `sagitta_m` from its ends' chord to its middle, at
// +z; 0: flat.
TriangleMesh MakeBentSheet(double length_m, double width_m, double thickness_m, double sagitta_m, int num_segments);

// A plate with sharp ridges along y at +z, `ridge_height_m` high.
TriangleMesh MakeCorrugatedPlate(const glm::dvec3& size_m, double ridge_height_m, int num_ridges);

// A ball with lumps of up to `lump_m` and, at each vertex, noise of up to `roughness_m`, as a scan has.
TriangleMesh MakeLumpyBall(double radius_m, double lump_m, double roughness_m, int num_segments, std::uint64_t seed);

// The same surface in four times the triangles: each edge is split at `fraction` of its length from the vertex with the
// lower number. 0.5: halves; near 0: slivers.
TriangleMesh SplitTriangles(const TriangleMesh& mesh, double fraction);

}  // namespace vps
