#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/parallel_for.hpp"
#include "core/result.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// Somewhere on a mesh: its frame, metres, and a triangle there, counted from 0 in the file's order.
struct MeshPlace {
  glm::dvec3 p_m{0.0};
  std::uint32_t triangle = 0;
};

// A closed chain of edges where the surface ends.
struct MeshHole {
  MeshPlace place;  // its middle
  std::size_t num_edges = 0;
  double length_m = 0.0;
  double area_m2 = 0.0;  // of a lid: triangles from its middle to its edges
};

// What was found and what was done about it. Lists of places are cut off at kMaxPlaces; counts are whole.
struct MeshReport {
  static constexpr std::size_t kMaxPlaces = 8;
  static constexpr std::size_t kMaxCrossings = 1000;  // the search for self-intersections ends here

  std::size_t num_triangles = 0;  // as read
  std::size_t num_vertices = 0;   // after welding
  Box box;
  double area_m2 = 0.0;
  double volume_m3 = 0.0;  // 0 for a sheet
  bool is_sheet = false;
  bool is_simple_solid = false;  // IsSimpleSolid of what comes back

  std::size_t num_zero_area = 0;    // dropped, unless the surface hangs together by them
  std::size_t num_doubled = 0;      // dropped: the same corners twice, alike or back to back
  std::size_t num_welded_near = 0;  // border corners put together though they differed by up to kWeldRatio of the size
  std::size_t num_splits = 0;       // border corners that lay on another triangle's edge, which was split there
  std::size_t num_parts = 0;
  std::size_t num_parts_turned = 0;
  std::size_t num_triangles_turned = 0;
  std::vector<MeshPlace> turned;
  std::size_t num_conflicts = 0;  // triangles that no turning makes agree with their neighbours
  std::vector<MeshPlace> conflicts;
  std::size_t num_many_sided_edges = 0;  // edges of three or more triangles
  std::vector<MeshPlace> many_sided_edges;
  std::size_t num_open_edges = 0;
  std::size_t num_holes = 0;
  std::vector<MeshHole> holes;    // the longest first
  std::size_t num_loose = 0;      // triangles that hang on nothing, dropped
  std::size_t num_crossings = 0;  // pairs of triangles that pass through each other, up to kMaxCrossings
  std::vector<MeshPlace> crossings;
};

// A mesh made fit for building from, with the report.
struct CheckedMesh {
  TriangleMesh mesh;
  MeshReport report;
};

// Border corners nearer to each other than this share of the box's diagonal are merged. Not derived: 17 roundings of a
// float (2^-24), which corners of one place written separately can differ by.
constexpr double kWeldRatio = 1e-6;
// Holes whose lids add less than this share of the surface are closed; a surface with larger ones is refused as open.
// Not derived: larger would invent surface, smaller refuses scans with gaps.
constexpr double kLargestHoles = 0.1;

// Welds, drops what has no area, turns triangles so that solids face outwards, and closes small holes by lids (a fan
// from the hole's middle), so that what comes back bounds a volume. `is_sheet`: the mesh is a sheet with two sides; its
// holes stay. Self-intersections are reported and kept: there the winding number determines the inside. Errors, with
// places: no triangle, none with an area, a corner that is not finite, an index out of range, a surface too open to be
// a solid or with a ring-shaped face missing, one that encloses no volume. `workers` share the work.
core::Result<CheckedMesh> CheckMesh(const TriangleMesh& mesh, bool is_sheet = false,
                                    core::ParallelFor* workers = nullptr);

// Closed, every edge with two consistently oriented triangles, none without area, none that intersects or lies on
// another: the normals determine inside and outside everywhere.
bool IsSimpleSolid(const TriangleMesh& mesh, core::ParallelFor* workers = nullptr);

// The same as CheckMesh from a file (LoadTriangles); errors begin with its name.
core::Result<CheckedMesh> LoadCheckedMesh(const std::filesystem::path& file, double scale = 1.0, bool is_sheet = false);

// One line for each thing that is not as it should be, in plain words with places; none for a clean mesh.
std::vector<std::string> DescribeDefects(const MeshReport& report);

// "(0.012, 0, 0.03) m, triangle 17".
std::string Describe(const MeshPlace& place);

}  // namespace vps
