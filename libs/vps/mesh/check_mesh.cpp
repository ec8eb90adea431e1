#include "vps/mesh/check_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "vps/mesh/edge_table.hpp"
#include "vps/mesh/load_mesh.hpp"
#include "vps/mesh/orient_parts.hpp"
#include "vps/mesh/self_intersection.hpp"
#include "vps/mesh/stitch_border.hpp"

namespace vps {
namespace {

// A triangle lower than this share of its longest edge counts as one without area. Not derived: between the rounding of
// double (2e-16) and that of files with floats (6e-8).
constexpr double kNoHeight = 1e-12;
// A surface with |volume| below this times area^1.5 encloses no volume. Not derived: a ball has 0.094, a square plate
// of 1:1000 has 3.5e-4.
constexpr double kNoVolume = 1e-7;

bool HasArea(const TriangleMesh& mesh, std::size_t triangle) {
  const auto [a, b, c] = mesh.corners(triangle);
  const double longest = std::max({glm::length(b - a), glm::length(c - b), glm::length(a - c)});
  return glm::length(glm::cross(b - a, c - a)) > kNoHeight * longest * longest;
}

// The mesh under repair; origin[i] is triangle i's number in the file.
struct Work {
  TriangleMesh mesh;
  std::vector<std::uint32_t> origin;

  void Keep(const std::vector<std::uint8_t>& is_kept) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < origin.size(); ++i) {
      if (is_kept[i] == 0) continue;
      mesh.triangles[count] = mesh.triangles[i];
      origin[count++] = origin[i];
    }
    mesh.triangles.resize(count);
    origin.resize(count);
  }
  [[nodiscard]] MeshPlace Place(std::uint32_t triangle) const {
    const auto [a, b, c] = mesh.corners(triangle);
    return {(a + b + c) / 3.0, origin[triangle]};
  }
  void AddPlaces(const std::vector<std::uint32_t>& triangles, std::vector<MeshPlace>* places) const {
    for (std::size_t i = 0; i < std::min(triangles.size(), MeshReport::kMaxPlaces); ++i) {
      places->push_back(Place(triangles[i]));
    }
  }
};

core::Result<void> CheckNumbers(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "holds no triangles; export the part's surface as a triangle mesh");
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t v : mesh.triangles[i]) {
      if (v >= mesh.vertices.size()) {
        return core::Fail(core::ErrorCode::kDamaged,
                          "triangle " + std::to_string(i) + " names vertex " + std::to_string(v) + " of " +
                              std::to_string(mesh.vertices.size()) + "; export the mesh again");
      }
      const glm::dvec3& p = mesh.vertices[v];
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
        return core::Fail(core::ErrorCode::kInvalidInput, "vertex " + std::to_string(v) + " of triangle " +
                                                              std::to_string(i) +
                                                              " is not a finite number; export the mesh again");
      }
    }
  }
  return {};
}

// One vertex per position; drops triangles that collapse.
Work Weld(const TriangleMesh& mesh) {
  const auto less = [](const glm::dvec3& a, const glm::dvec3& b) {
    return a.x != b.x ? a.x < b.x : (a.y != b.y ? a.y < b.y : a.z < b.z);
  };
  std::vector<std::uint32_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return less(mesh.vertices[a], mesh.vertices[b]) || (mesh.vertices[a] == mesh.vertices[b] && a < b);
  });
  std::vector<std::uint32_t> first(mesh.vertices.size());  // of those at the same position
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool is_same = i > 0 && mesh.vertices[order[i]] == mesh.vertices[order[i - 1]];
    first[order[i]] = is_same ? first[order[i - 1]] : order[i];
  }
  Work work;
  std::vector<std::int64_t> index(mesh.vertices.size(), -1);
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    std::array<std::uint32_t, 3> t = mesh.triangles[i];
    for (std::uint32_t& v : t) v = first[v];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    for (std::uint32_t& v : t) {
      if (index[v] < 0) {
        index[v] = static_cast<std::int64_t>(work.mesh.vertices.size());
        work.mesh.vertices.push_back(mesh.vertices[v]);
      }
      v = static_cast<std::uint32_t>(index[v]);
    }
    work.mesh.triangles.push_back(t);
    work.origin.push_back(i);
  }
  return work;
}

// Triangles with the same corners: one of those alike stays, and two back to back leave nothing between them, so both
// go. On a sheet, which has two sides, one stays.
std::size_t DropDoubled(bool is_sheet, Work* work) {
  struct Entry {
    std::uint32_t count[2] = {0, 0};  // of each winding
    std::uint32_t kept[2] = {0, 0};
  };
  const auto key_of = [&](std::size_t i, bool* is_odd) {
    auto t = work->mesh.triangles[i];
    *is_odd = false;
    for (const auto& [a, b] : {std::pair{0, 1}, std::pair{1, 2}, std::pair{0, 1}}) {
      if (t[a] <= t[b]) continue;
      std::swap(t[a], t[b]);
      *is_odd = !*is_odd;
    }
    return t;
  };
  std::map<std::array<std::uint32_t, 3>, Entry> entries;
  bool is_odd = false;
  for (std::size_t i = 0; i < work->mesh.triangles.size(); ++i) {
    Entry& entry = entries[key_of(i, &is_odd)];
    ++entry.count[is_odd ? 1 : 0];
  }
  std::vector<std::uint8_t> is_kept(work->mesh.triangles.size(), 1);
  std::size_t num_dropped = 0;
  for (std::size_t i = 0; i < is_kept.size(); ++i) {
    Entry& entry = entries[key_of(i, &is_odd)];
    const bool is_pair = entry.count[0] > 0 && entry.count[1] > 0;
    const bool has_kept = entry.kept[0] + entry.kept[1] > 0;
    is_kept[i] = (is_pair && !is_sheet) || has_kept ? 0 : 1;
    if (is_kept[i] == 0) ++num_dropped;
    if (is_kept[i] != 0) ++entry.kept[is_odd ? 1 : 0];
  }
  work->Keep(is_kept);
  return num_dropped;
}

// Needles with three corners in a line can be what holds a surface together: where a long edge meets two short ones.
// They go only if no edge opens.
std::size_t DropNeedles(Work* work) {
  std::vector<std::uint8_t> is_kept(work->mesh.triangles.size(), 1);
  std::size_t num_needles = 0;
  for (std::size_t i = 0; i < is_kept.size(); ++i) {
    is_kept[i] = HasArea(work->mesh, i) ? 1 : 0;
    num_needles += is_kept[i] == 0 ? 1 : 0;
  }
  if (num_needles == 0) return 0;
  Work without = *work;
  without.Keep(is_kept);
  if (without.mesh.triangles.empty() || CountOpenEdges(without.mesh) <= CountOpenEdges(work->mesh)) *work = without;
  return num_needles;
}

void FindManySidedEdges(const Work& work, MeshReport* report) {
  const std::vector<EdgeUse> edges = SortedEdges(work.mesh);
  for (std::size_t i = 0; i < edges.size();) {
    const std::size_t end = EndOfEdge(edges, i);
    if (end - i > 2) {
      ++report->num_many_sided_edges;
      if (report->many_sided_edges.size() < MeshReport::kMaxPlaces) {
        const glm::dvec3& a = work.mesh.vertices[edges[i].key >> 32];
        const glm::dvec3& b = work.mesh.vertices[edges[i].key & 0xffffffffU];
        report->many_sided_edges.push_back({0.5 * (a + b), work.origin[edges[i].triangle]});
      }
    }
    i = end;
  }
}

struct Lid {
  glm::dvec3 middle{0.0};
  glm::dvec3 area_normal_m2{0.0};
  MeshHole hole;
};

Lid MeasureLid(const TriangleMesh& mesh, const std::vector<std::uint32_t>& loop) {
  Lid lid;
  for (const std::uint32_t v : loop) lid.middle += mesh.vertices[v] / static_cast<double>(loop.size());
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const glm::dvec3& a = mesh.vertices[loop[i]];
    const glm::dvec3& b = mesh.vertices[loop[(i + 1) % loop.size()]];
    lid.hole.length_m += glm::length(b - a);
    lid.area_normal_m2 += 0.5 * glm::cross(b - lid.middle, a - lid.middle);
    lid.hole.area_m2 += 0.5 * glm::length(glm::cross(a - lid.middle, b - lid.middle));
  }
  lid.hole.num_edges = loop.size();
  lid.hole.place.p_m = lid.middle;
  return lid;
}

// A fan from the hole's middle that runs against the loop, as a neighbour across an edge does.
void AddLid(const std::vector<std::uint32_t>& loop, const Lid& lid, TriangleMesh* mesh) {
  if (loop.size() < 3) return;
  if (loop.size() == 3) {
    mesh->triangles.push_back({loop[1], loop[0], loop[2]});
    return;
  }
  const auto middle = static_cast<std::uint32_t>(mesh->vertices.size());
  mesh->vertices.push_back(lid.middle);
  for (std::size_t i = 0; i < loop.size(); ++i) {
    mesh->triangles.push_back({loop[(i + 1) % loop.size()], loop[i], middle});
  }
}

// A ring-shaped face is missing between two loops in one plane: lids would close what the inner one leaves open. Loops
// are such a pair when their middles are nearer than 0.3 sqrt(outer area) and their area normals more than 120 degrees
// apart; neither limit is derived (test CheckMesh.RefusesAMissingRing).
const Lid* FindNested(const std::vector<Lid>& lids) {
  for (const Lid& outer : lids) {
    for (const Lid& inner : lids) {
      const double reach = 0.3 * std::sqrt(outer.hole.area_m2);
      const double facing = glm::dot(outer.area_normal_m2, inner.area_normal_m2);
      const double plain = glm::length(outer.area_normal_m2) * glm::length(inner.area_normal_m2);
      if (&outer == &inner || glm::length(outer.middle - inner.middle) > reach) continue;
      if (facing < -0.5 * plain && plain > 0.0) return &inner;
    }
  }
  return nullptr;
}

constexpr const char* kSheetFix =
    "; close the mesh, or, if the part is a thin sheet, give its thickness (sheet_thickness_m)";

// First triangle of the file at each loop.
void NameTriangles(const Work& work, const std::vector<std::vector<std::uint32_t>>& loops, std::vector<Lid>* lids) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> triangle_at;
  for (std::uint32_t i = 0; i < work.mesh.triangles.size(); ++i) {
    const auto& t = work.mesh.triangles[i];
    for (int k = 0; k < 3; ++k) triangle_at.try_emplace({t[k], t[(k + 1) % 3]}, work.origin[i]);
  }
  for (std::size_t i = 0; i < loops.size(); ++i) {
    (*lids)[i].hole.place.triangle = triangle_at[{loops[i][0], loops[i][1 % loops[i].size()]}];
  }
}

// Finds holes, and closes small ones of a solid.
core::Result<void> CloseHoles(bool is_sheet, Work* work, MeshReport* report) {
  report->num_open_edges = CountOpenEdges(work->mesh);
  if (report->num_open_edges == 0) return {};
  const auto loops = BoundaryLoops(work->mesh);
  report->num_holes = loops.size();
  std::vector<Lid> lids;
  double lid_area = 0.0;
  for (const auto& loop : loops) {
    lids.push_back(MeasureLid(work->mesh, loop));
    lid_area += lids.back().hole.area_m2;
  }
  NameTriangles(*work, loops, &lids);
  for (const Lid& lid : lids) report->holes.push_back(lid.hole);
  std::stable_sort(report->holes.begin(), report->holes.end(),
                   [](const MeshHole& a, const MeshHole& b) { return a.length_m > b.length_m; });
  if (report->holes.size() > MeshReport::kMaxPlaces) report->holes.resize(MeshReport::kMaxPlaces);
  if (is_sheet) return {};
  if (lid_area > kLargestHoles * report->area_m2) {
    char text[200];
    std::snprintf(text, sizeof text, "is open: %zu open edges around %zu holes; the longest is %.4g m long, around ",
                  report->num_open_edges, report->num_holes, report->holes[0].length_m);
    return core::Fail(core::ErrorCode::kInvalidInput, text + Describe(report->holes[0].place) + kSheetFix);
  }
  if (const Lid* nested = FindNested(lids)) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "is open: a ring-shaped face is missing around " + Describe(nested->hole.place) + kSheetFix);
  }
  for (std::size_t i = 0; i < loops.size(); ++i) AddLid(loops[i], lids[i], &work->mesh);
  return {};
}

double VolumeOf(const TriangleMesh& mesh, const Box& box) {
  const glm::dvec3 centre = 0.5 * (box.lower + box.upper);
  double volume = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.corners(i);
    volume += glm::dot(a - centre, glm::cross(b - centre, c - centre)) / 6.0;
  }
  return volume;
}

void FindCrossingPlaces(Work* work, std::size_t num_own, core::ParallelFor* workers, MeshReport* report) {
  const auto crossings = FindCrossings(work->mesh, MeshReport::kMaxCrossings, workers);
  report->num_crossings = crossings.size();
  // Reported places are at least 2 % of the box's diagonal apart (not derived): eight neighbours would be one place.
  const double apart_m = 0.02 * glm::length(report->box.upper - report->box.lower);
  for (const Crossing& crossing : crossings) {
    const bool is_near = std::any_of(report->crossings.begin(), report->crossings.end(), [&](const MeshPlace& place) {
      return glm::length(place.p_m - crossing.p_m) < apart_m;
    });
    if (is_near || report->crossings.size() >= MeshReport::kMaxPlaces) continue;
    const std::uint32_t triangle = crossing.a < num_own ? crossing.a : crossing.b;
    report->crossings.push_back({crossing.p_m, triangle < num_own ? work->origin[triangle] : 0});
  }
}

}  // namespace

bool IsSimpleSolid(const TriangleMesh& mesh, core::ParallelFor* workers) {
  const std::vector<EdgeUse> edges = SortedEdges(mesh);
  for (std::size_t i = 0; i < edges.size(); i += 2) {
    if (EndOfEdge(edges, i) != i + 2 || edges[i].is_forward == edges[i + 1].is_forward) return false;
    const EdgeUse& a = edges[i];
    const EdgeUse& b = edges[i + 1];
    const bool is_back_to_back =
        mesh.triangles[a.triangle][(a.corner + 2) % 3] == mesh.triangles[b.triangle][(b.corner + 2) % 3];
    if (is_back_to_back) return false;
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (!HasArea(mesh, i)) return false;
  }
  return !mesh.triangles.empty() && !HasSelfIntersection(mesh, workers);
}

core::Result<CheckedMesh> CheckMesh(const TriangleMesh& mesh, bool is_sheet, core::ParallelFor* workers) {
  if (const auto good = CheckNumbers(mesh); !good) return tl::unexpected(good.error());
  CheckedMesh checked;
  MeshReport& report = checked.report;
  report.is_sheet = is_sheet;
  report.num_triangles = mesh.triangles.size();
  Work work = Weld(mesh);
  report.num_zero_area = mesh.triangles.size() - work.mesh.triangles.size() + DropNeedles(&work);
  if (work.mesh.triangles.empty() || !(SurfaceArea_m2(work.mesh) > 0.0)) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "holds no triangle with an area: all " + std::to_string(mesh.triangles.size()) +
                          " have collapsed to a line or a point; export the mesh again, with more digits");
  }
  report.box = BoundingBox(work.mesh);
  const double reach_m = kWeldRatio * glm::length(report.box.upper - report.box.lower);
  report.num_welded_near = WeldBorder(reach_m, &work.mesh, &work.origin);
  report.num_splits = SplitAtBorderCorners(reach_m, &work.mesh, &work.origin);
  report.num_doubled = DropDoubled(is_sheet, &work);
  const auto no_volume = [] {
    return core::Fail(core::ErrorCode::kInvalidInput, std::string("encloses no volume") + kSheetFix);
  };
  if (work.mesh.triangles.empty()) return no_volume();
  report.num_vertices = work.mesh.vertices.size();
  report.area_m2 = SurfaceArea_m2(work.mesh);
  FindManySidedEdges(work, &report);

  const Orientation orientation = OrientParts(&work.mesh);
  report.num_parts = orientation.num_parts;
  report.num_parts_turned = orientation.num_parts_turned;
  report.num_triangles_turned = orientation.turned.size();
  report.num_conflicts = orientation.conflicting.size();
  work.AddPlaces(orientation.turned, &report.turned);
  work.AddPlaces(orientation.conflicting, &report.conflicts);

  std::size_t num_own = work.mesh.triangles.size();
  if (const auto good = CloseHoles(is_sheet, &work, &report); !good) return tl::unexpected(good.error());
  if (!is_sheet && report.num_holes > 0) {
    // A loose triangle and its lid lie back to back.
    work.origin.resize(work.mesh.triangles.size(), 0);
    report.num_loose = DropDoubled(false, &work) / 2;
    num_own -= report.num_loose;
    if (work.mesh.triangles.empty()) return no_volume();
  }
  if (!is_sheet) {
    report.volume_m3 = VolumeOf(work.mesh, report.box);
    if (!(std::abs(report.volume_m3) > kNoVolume * std::pow(report.area_m2, 1.5))) return no_volume();
  }
  FindCrossingPlaces(&work, num_own, workers, &report);
  report.is_simple_solid = !is_sheet && report.num_crossings == 0 && IsSimpleSolid(work.mesh, workers);
  checked.mesh = std::move(work.mesh);
  return checked;
}

core::Result<CheckedMesh> LoadCheckedMesh(const std::filesystem::path& file, double scale, bool is_sheet) {
  const auto triangles = LoadTriangles(file, scale);
  if (!triangles) return tl::unexpected(triangles.error());
  auto checked = CheckMesh(*triangles, is_sheet);
  if (!checked) return core::Fail(checked.error().code, file.string() + ": the mesh " + checked.error().detail);
  return checked;
}

}  // namespace vps
