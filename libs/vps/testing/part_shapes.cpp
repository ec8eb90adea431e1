#include "vps/testing/part_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "vps/testing/case_random.hpp"
#include "vps/testing/quads.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

using Ring = std::vector<glm::dvec3>;

// A flat polygon of a convex part around the origin, in either direction.
void AddConvexFace(TriangleMesh* mesh, std::vector<std::uint32_t> corners) {
  const glm::dvec3& a = mesh->vertices[corners[0]];
  const glm::dvec3 normal = glm::cross(mesh->vertices[corners[1]] - a, mesh->vertices[corners[2]] - a);
  if (glm::dot(normal, a) < 0.0) std::reverse(corners.begin(), corners.end());
  for (std::size_t i = 2; i < corners.size(); ++i) mesh->triangles.push_back({corners[0], corners[i - 1], corners[i]});
}

// Rings of equal vertex count, counter-clockwise seen from +z, each joined to the next; seen from outside the next lies
// above. Quads are cut from (i, j) to (i + 1, j + 1). A loop joins the last ring to the first; else both end rings are
// closed by fans around their middles.
TriangleMesh JoinRings(const std::vector<Ring>& rings, bool is_loop) {
  TriangleMesh mesh;
  for (const Ring& ring : rings) mesh.vertices.insert(mesh.vertices.end(), ring.begin(), ring.end());
  const std::size_t n = rings[0].size();
  const auto at = [&](std::size_t i, std::size_t j) {
    return static_cast<std::uint32_t>((i % rings.size()) * n + j % n);
  };
  for (std::size_t i = 0; i + (is_loop ? 0 : 1) < rings.size(); ++i) {
    for (std::size_t j = 0; j < n; ++j) AddQuad(&mesh, at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
  }
  if (is_loop) return mesh;
  for (const std::size_t end : {std::size_t{0}, rings.size() - 1}) {
    glm::dvec3 middle(0.0);
    for (const glm::dvec3& v : rings[end]) middle += v / static_cast<double>(n);
    const auto hub = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(middle);
    for (std::size_t j = 0; j < n; ++j) {
      const std::uint32_t a = at(end, j);
      const std::uint32_t b = at(end, j + 1);
      mesh.triangles.push_back(end == 0 ? std::array{hub, b, a} : std::array{hub, a, b});
    }
  }
  return mesh;
}

Ring Circle(double radius_m, double z_m, int num_segments) {
  Ring ring;
  for (int j = 0; j < num_segments; ++j) {
    const double u = 2.0 * std::numbers::pi * j / num_segments;
    ring.emplace_back(radius_m * std::cos(u), radius_m * std::sin(u), z_m);
  }
  return ring;
}

// A cross section in x and z, above and below at the same places from left to right, drawn out along y.
TriangleMesh ExtrudeStrip(const std::vector<glm::dvec2>& above, const std::vector<glm::dvec2>& below, double width_m) {
  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(above.size());
  for (const double y : {-0.5 * width_m, 0.5 * width_m}) {
    for (const glm::dvec2& p : above) mesh.vertices.emplace_back(p.x, y, p.y);
    for (const glm::dvec2& p : below) mesh.vertices.emplace_back(p.x, y, p.y);
  }
  const auto top = [n](std::uint32_t side, std::uint32_t i) { return 2 * n * side + i; };
  const auto bottom = [n](std::uint32_t side, std::uint32_t i) { return 2 * n * side + n + i; };
  for (std::uint32_t i = 0; i + 1 < n; ++i) {
    AddQuad(&mesh, top(0, i), top(0, i + 1), top(1, i + 1), top(1, i));
    AddQuad(&mesh, bottom(0, i), bottom(1, i), bottom(1, i + 1), bottom(0, i + 1));
    AddQuad(&mesh, bottom(0, i), bottom(0, i + 1), top(0, i + 1), top(0, i));
    AddQuad(&mesh, bottom(1, i), top(1, i), top(1, i + 1), bottom(1, i + 1));
  }
  AddQuad(&mesh, bottom(0, 0), top(0, 0), top(1, 0), bottom(1, 0));
  AddQuad(&mesh, bottom(0, n - 1), bottom(1, n - 1), top(1, n - 1), top(0, n - 1));
  return mesh;
}

// Depth below the crest at a share of the pitch in [0, 1): a quarter each of crest, flank, root, flank.
double ThreadCut(double share) {
  if (share < 0.25) return 0.0;
  if (share < 0.5) return 4.0 * share - 1.0;
  return share < 0.75 ? 1.0 : 4.0 - 4.0 * share;
}

}  // namespace

TriangleMesh MakeBevelledBlock(const glm::dvec3& size_m, double bevel_m) {
  TriangleMesh mesh;
  // Corner c (a bit for each axis' side) has a vertex on the face of each axis k: number 3 c + k.
  for (int c = 0; c < 8; ++c) {
    const glm::dvec3 side(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1);
    for (int k = 0; k < 3; ++k) {
      glm::dvec3 p = 0.5 * size_m - bevel_m;
      p[k] = 0.5 * size_m[k];
      mesh.vertices.push_back(side * p);
    }
  }
  const auto at = [](int corner, int axis) { return static_cast<std::uint32_t>(3 * corner + axis); };
  for (int c = 0; c < 8; ++c) AddConvexFace(&mesh, {at(c, 0), at(c, 1), at(c, 2)});
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    const int m = (k + 2) % 3;
    for (const int side : {0, 1 << k}) {
      AddConvexFace(&mesh, {at(side, k), at(side | 1 << l, k), at(side | 1 << l | 1 << m, k), at(side | 1 << m, k)});
    }
    // The bevels along axis m, between the faces of k and l.
    for (const int c : {0, 1 << k, 1 << l, 1 << k | 1 << l}) {
      AddConvexFace(&mesh, {at(c, k), at(c, l), at(c | 1 << m, l), at(c | 1 << m, k)});
    }
  }
  return mesh;
}

// Ring i is at height i / n of a pitch. Its radius at segment j depends on i - j alone, so that crest and root run
// along the diagonals of the quads.
TriangleMesh MakeThreadedRod(const Thread& thread) {
  const int n = thread.num_segments;
  std::vector<Ring> rings;
  for (int i = 0; i <= n * thread.num_turns; ++i) {
    Ring ring;
    for (int j = 0; j < n; ++j) {
      const double cut = ThreadCut(static_cast<double>((i - j + n) % n) / n);
      const double radius_m = thread.radius_m - thread.depth_m * cut;
      const double u = 2.0 * std::numbers::pi * j / n;
      ring.emplace_back(radius_m * std::cos(u), radius_m * std::sin(u),
                        thread.pitch_m * (static_cast<double>(i) / n - 0.5 * thread.num_turns));
    }
    rings.push_back(std::move(ring));
  }
  return JoinRings(rings, false);
}

TriangleMesh MakeTube(double outer_radius_m, double inner_radius_m, double length_m, int num_segments) {
  const double z = 0.5 * length_m;
  return JoinRings({Circle(outer_radius_m, -z, num_segments), Circle(outer_radius_m, z, num_segments),
                    Circle(inner_radius_m, z, num_segments), Circle(inner_radius_m, -z, num_segments)},
                   true);
}

TriangleMesh MakeTray(const glm::dvec3& size_m, double wall_m) {
  const auto rectangle = [&](double inset_m, double z_m) {
    const double x = 0.5 * size_m.x - inset_m;
    const double y = 0.5 * size_m.y - inset_m;
    return Ring{{-x, -y, z_m}, {x, -y, z_m}, {x, y, z_m}, {-x, y, z_m}};
  };
  const double z = 0.5 * size_m.z;
  return JoinRings({rectangle(0.0, -z), rectangle(0.0, z), rectangle(wall_m, z), rectangle(wall_m, wall_m - z)}, false);
}

TriangleMesh MakeWedge(double length_m, double width_m, double height_m, double edge_width_m) {
  TriangleMesh mesh;
  std::vector<glm::dvec2> section = {{-0.5 * width_m, -0.5 * height_m}, {0.5 * width_m, -0.5 * height_m}};
  section.emplace_back(0.5 * edge_width_m, 0.5 * height_m);
  if (edge_width_m > 0.0) section.emplace_back(-0.5 * edge_width_m, 0.5 * height_m);
  const auto n = static_cast<std::uint32_t>(section.size());
  for (const double y : {-0.5 * length_m, 0.5 * length_m}) {
    for (const glm::dvec2& p : section) mesh.vertices.emplace_back(p.x, y, p.y);
  }
  std::vector<std::uint32_t> front, back;
  for (std::uint32_t i = 0; i < n; ++i) {
    front.push_back(i);
    back.push_back(n + i);
    AddConvexFace(&mesh, {i, (i + 1) % n, n + (i + 1) % n, n + i});
  }
  AddConvexFace(&mesh, front);
  AddConvexFace(&mesh, back);
  return mesh;
}

TriangleMesh MakeNeedle(double radius_m, double length_m, double taper_length_m, double tip_radius_m,
                        int num_segments) {
  const double z = 0.5 * length_m;
  return JoinRings({Circle(radius_m, -z, num_segments), Circle(radius_m, z - taper_length_m, num_segments),
                    Circle(tip_radius_m, z, num_segments)},
                   false);
}

// An arc of length L that turns by 2 a has the radius L / (2 a), and its middle is L (1 - cos a) / (2 a) above its
// ends: L a / 4 for small a. So a = 4 s / L; the next term is a^2 / 12 of it.
TriangleMesh MakeBentSheet(double length_m, double width_m, double thickness_m, double sagitta_m, int num_segments) {
  const double half_turn = 4.0 * sagitta_m / length_m;
  std::vector<glm::dvec2> above, below;
  for (int i = 0; i <= num_segments; ++i) {
    const double share = static_cast<double>(i) / num_segments - 0.5;
    for (const double z : {0.5 * thickness_m, -0.5 * thickness_m}) {
      glm::dvec2 p(share * length_m, z);
      if (half_turn > 0.0) {
        const double radius_m = length_m / (2.0 * half_turn);
        const double angle = 2.0 * half_turn * share;
        p = {(radius_m + z) * std::sin(angle), (radius_m + z) * std::cos(angle) - radius_m};
      }
      (z > 0.0 ? above : below).push_back(p);
    }
  }
  return ExtrudeStrip(above, below, width_m);
}

TriangleMesh MakeCorrugatedPlate(const glm::dvec3& size_m, double ridge_height_m, int num_ridges) {
  std::vector<glm::dvec2> above, below;
  for (int i = 0; i <= 2 * num_ridges; ++i) {
    const double x = size_m.x * (0.5 * i / num_ridges - 0.5);
    above.emplace_back(x, 0.5 * size_m.z - (i % 2 == 0 ? ridge_height_m : 0.0));
    below.emplace_back(x, -0.5 * size_m.z);
  }
  return ExtrudeStrip(above, below, size_m.y);
}

TriangleMesh MakeLumpyBall(double radius_m, double lump_m, double roughness_m, int num_segments, std::uint64_t seed) {
  TriangleMesh mesh = MakeSphere(radius_m, num_segments);
  CaseRandom random(seed);
  // Waves through the ball; their number is not derived.
  constexpr int kWaves = 6;
  std::vector<glm::dvec4> waves;
  for (int k = 0; k < kWaves; ++k)
    waves.emplace_back(random.Uniform(2.0, 6.0) * random.Direction(), random.Uniform(0, 6));
  for (glm::dvec3& v : mesh.vertices) {
    const glm::dvec3 outward = v / radius_m;
    double height_m = roughness_m * random.Uniform(-1.0, 1.0);
    for (const glm::dvec4& w : waves) height_m += lump_m / kWaves * std::sin(glm::dot(glm::dvec3(w), outward) + w.w);
    v += height_m * outward;
  }
  return mesh;
}

TriangleMesh SplitTriangles(const TriangleMesh& mesh, double fraction) {
  TriangleMesh split;
  split.vertices = mesh.vertices;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> places;
  const auto between = [&](std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    const auto [place, is_new] = places.try_emplace({a, b}, static_cast<std::uint32_t>(split.vertices.size()));
    if (is_new) split.vertices.push_back(glm::mix(mesh.vertices[a], mesh.vertices[b], fraction));
    return place->second;
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::uint32_t ab = between(a, b);
    const std::uint32_t bc = between(b, c);
    const std::uint32_t ca = between(c, a);
    split.triangles.push_back({a, ab, ca});
    split.triangles.push_back({b, bc, ab});
    split.triangles.push_back({c, ca, bc});
    split.triangles.push_back({ab, bc, ca});
  }
  return split;
}

}  // namespace vps
