#pragma once

#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// Closed meshes with outward normals, for tests, benchmarks and scenes made by programs. Centred on the origin.
TriangleMesh MakeBox(const glm::dvec3& size_m);
TriangleMesh MakeSphere(double radius_m, int num_segments);                            // vertices on the sphere
TriangleMesh MakeTorus(double major_m, double minor_m, int num_major, int num_minor);  // axis z
TriangleMesh MakeCylinder(double radius_m, double length_m, int num_segments);         // axis z

// A block of size x size x height with a round hole along z: a socket for a peg.
TriangleMesh MakeBlockWithHole(double size_m, double height_m, double hole_radius_m, int num_segments);

// Both in one mesh, `other` moved by shift_m.
TriangleMesh Joined(TriangleMesh mesh, const TriangleMesh& other, const glm::dvec3& shift_m = glm::dvec3(0.0));

}  // namespace vps
