// What is seen against what is touched: the visual meshes of the scenarios and their collision meshes.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <set>

#include "scene/load_scenario.hpp"
#include "vps/mesh/box_tree.hpp"
#include "vps/mesh/load_mesh.hpp"
#include "vps/mesh/nearest_on_triangle.hpp"

namespace visual_node {
namespace {

// Sharp edges of a collision mesh are rounded where they are seen: up to kEdgeTolerance_m within kEdge_m of an edge.
constexpr double kTolerance_m = 2e-4, kEdgeTolerance_m = 5e-4, kEdge_m = 5e-4;

std::filesystem::path Scenarios() {
  return std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios";
}

double DistanceTo(const vps::TriangleMesh& mesh, const vps::BoxTree& tree, const glm::dvec3& p, double reach_m) {
  double nearest = reach_m;
  vps::ForOverlapping(tree, {p - reach_m, p + reach_m}, [&](std::uint32_t triangle) {
    const auto& [a, b, c] = mesh.triangles[triangle];
    const glm::dvec3 pa = mesh.vertices[a] - p, pb = mesh.vertices[b] - p, pc = mesh.vertices[c] - p;
    nearest = std::min(nearest, glm::length(vps::NearestOnTriangle(pa, pb, pc, glm::cross(pb - pa, pc - pa)).place));
  });
  return nearest;
}

// The edges at which faces meet at more than 25 degrees, each as a triangle without area.
vps::TriangleMesh SharpEdges(const vps::TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, glm::dvec3> normals;
  vps::TriangleMesh edges;
  edges.vertices = mesh.vertices;
  for (const auto& t : mesh.triangles) {
    const glm::dvec3 n = glm::normalize(
        glm::cross(mesh.vertices[t[1]] - mesh.vertices[t[0]], mesh.vertices[t[2]] - mesh.vertices[t[0]]));
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i], b = t[(i + 1) % 3];
      const auto [other, is_new] = normals.try_emplace(std::minmax(a, b), n);
      if (!is_new && glm::dot(other->second, n) < 0.9) edges.triangles.push_back({a, b, b});
    }
  }
  return edges;
}

double DistanceToEdge(const vps::TriangleMesh& edges, const vps::BoxTree& tree, const glm::dvec3& p, double reach_m) {
  double nearest = reach_m;
  vps::ForOverlapping(tree, {p - reach_m, p + reach_m}, [&](std::uint32_t edge) {
    const glm::dvec3 &a = edges.vertices[edges.triangles[edge][0]], &b = edges.vertices[edges.triangles[edge][1]];
    const double t = std::clamp(glm::dot(p - a, b - a) / glm::dot(b - a, b - a), 0.0, 1.0);
    nearest = std::min(nearest, glm::distance(p, a + t * (b - a)));
  });
  return nearest;
}

struct Agreement {
  struct Worst {
    double distance_m = 0.0;
    glm::dvec3 place_m{0.0};
  };
  Worst at_faces, at_edges;
  int num_samples = 0;
};

// From points of the collision surface where `is_touched`, about 2 mm apart, to the visual surface.
Agreement Compare(const vps::TriangleMesh& collision, const vps::TriangleMesh& visual,
                  const std::function<bool(const glm::dvec3&)>& is_touched) {
  constexpr double kStep_m = 2e-3, kReach_m = 2e-3;
  const vps::BoxTree tree = vps::BuildBoxTree(visual);
  const vps::TriangleMesh edges = SharpEdges(collision);
  const vps::BoxTree edge_tree = vps::BuildBoxTree(edges);
  Agreement result;
  for (const auto& [i, j, k] : collision.triangles) {
    const glm::dvec3 &a = collision.vertices[i], &b = collision.vertices[j], &c = collision.vertices[k];
    const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
    const int n = std::max(1, static_cast<int>(std::ceil(longest / kStep_m)));
    for (int u = 0; u <= n; ++u) {
      for (int v = 0; u + v <= n; ++v) {
        const glm::dvec3 p = a + static_cast<double>(u) / n * (b - a) + static_cast<double>(v) / n * (c - a);
        if (!is_touched(p)) continue;
        ++result.num_samples;
        const double distance = DistanceTo(visual, tree, p, kReach_m);
        const bool is_edge = DistanceToEdge(edges, edge_tree, p, kEdge_m) < kEdge_m;
        Agreement::Worst& worst = is_edge ? result.at_edges : result.at_faces;
        if (distance > worst.distance_m) worst = {distance, p};
      }
    }
  }
  return result;
}

// Hidden for good, or out of a hand's way, and therefore not alike: the satellite's insulated sides, its outer strips
// and the walls of its openings behind the cavities; the outside of a cavity, which is inside the satellite; the
// undersides of what is mounted on the face; where the wrist is inside the palm; the
// sides of a servicer.
bool IsTouched(const std::string& object, const glm::dvec3& p) {
  if (object == "satellite") {
    const auto is_in = [&](double x, double y) { return std::abs(p.x - x) < 0.053 && std::abs(p.y - y) < 0.053; };
    const bool is_under_post = p.z < 1e-4 && std::abs(std::abs(p.y) - 0.076) < 0.0061;
    return p.z > -1e-4 && std::abs(p.x) < 0.385 && std::abs(p.y) < 0.295 && !is_in(0, 0) && !is_in(0, 0.19) &&
           !is_under_post;
  }
  if (object.starts_with("cavity")) {
    const bool is_inside = std::max(std::abs(p.x), std::abs(p.y)) < 0.0455 && p.z > -0.1006;
    return is_inside || p.z > 1e-4;
  }
  if (object == "servicer") return p.z > 0.2 - 1e-4 && std::max(std::abs(p.x) - 0.3, std::abs(p.y) - 0.25) < -1e-3;
  if (object == "palm") return std::abs(p.z - 0.101) > 1e-6;  // the wrist begins inside the housing
  if (object == "switch_base" || object == "holder" || object.starts_with("bracket")) return p.z > 1e-3;
  return true;
}

// Of an arm only the tool is pushed.
bool IsAnyTouched(const std::string& object) {
  const bool is_link = object.starts_with("left_") || object.starts_with("right_");
  return !is_link || object.ends_with("_7");
}

TEST(VisualMeshes, AgreeWithTheCollisionMeshesWhereAHandTouches) {
  int num_pairs = 0;
  for (const char* name : {"module_replacement", "peg_in_hole", "service_robot", "touch"}) {
    const auto scenario = scene::LoadScenario(Scenarios() / name);
    ASSERT_TRUE(scenario);
    std::set<std::pair<std::filesystem::path, std::filesystem::path>> seen;
    for (const scene::Object& object : scenario->objects) {
      if (object.collision_mesh.empty() || object.collision_mesh == object.visual_mesh) continue;
      if (!seen.insert({object.collision_mesh, object.visual_mesh}).second) continue;
      if (!IsAnyTouched(object.name)) continue;
      const auto collision = vps::LoadMesh(object.collision_mesh);
      const auto visual = vps::LoadTriangles(object.visual_mesh);
      ASSERT_TRUE(collision && visual);
      const Agreement found =
          Compare(*collision, *visual, [&](const glm::dvec3& p) { return IsTouched(object.name, p); });
      EXPECT_GT(found.num_samples, 100) << object.name;
      const auto expect = [&](const Agreement::Worst& worst, double tolerance_m) {
        const glm::dvec3 p_mm = 1e3 * worst.place_m;
        EXPECT_LE(worst.distance_m, tolerance_m) << name << ", " << object.name << " at (" << p_mm.x << ", " << p_mm.y
                                                 << ", " << p_mm.z << ") mm of its mesh frame";
      };
      expect(found.at_faces, kTolerance_m);
      expect(found.at_edges, kEdgeTolerance_m);
      std::printf("%s, %s: %.3f mm, at edges %.3f mm, over %d points\n", name, object.name.c_str(),
                  1e3 * found.at_faces.distance_m, 1e3 * found.at_edges.distance_m, found.num_samples);
      ++num_pairs;
    }
  }
  EXPECT_GE(num_pairs, 20);
}

// A place at which something is put in: nothing is seen above its floor.
struct Opening {
  const char* mesh;
  glm::dvec2 centre_m;
  double half_m;
  double floor_m;
};

TEST(VisualMeshes, LeaveOpenWhatIsOpen) {
  for (const Opening& opening :
       {Opening{"satellite", {0, 0}, 0.050, -0.1}, Opening{"satellite", {0, 0.19}, 0.050, -0.1},
        Opening{"cavity", {0, 0}, 0.040, -0.1003}, Opening{"module", {0, 0}, 0.007, -0.0104},
        Opening{"holder", {0, 0}, 0.009, 0.0041}, Opening{"bracket", {0, 0}, 0.029, 0.0}}) {
    const auto mesh =
        vps::LoadTriangles(Scenarios() / "module_replacement" / "meshes" / (std::string(opening.mesh) + ".glb"));
    ASSERT_TRUE(mesh);
    const vps::BoxTree tree = vps::BuildBoxTree(*mesh);
    for (int i = 0; i < 100; ++i) {
      const glm::dvec2 at =
          opening.centre_m + opening.half_m * (glm::dvec2(i % 10, i / 10) / 4.5 - 1.0) + glm::dvec2(1.3e-5, 0.7e-5);
      vps::ForOverlapping(tree, {{at, opening.floor_m}, {at, 1.0}}, [&](std::uint32_t triangle) {
        const auto& [a, b, c] = mesh->triangles[triangle];
        const auto side = [&](std::uint32_t from, std::uint32_t to) {
          const glm::dvec2 along(mesh->vertices[to] - mesh->vertices[from]);
          const glm::dvec2 across = at - glm::dvec2(mesh->vertices[from]);
          return along.x * across.y - along.y * across.x > 0.0;
        };
        const bool is_above =
            std::max({mesh->vertices[a].z, mesh->vertices[b].z, mesh->vertices[c].z}) > opening.floor_m;
        EXPECT_FALSE(is_above && side(a, b) == side(b, c) && side(b, c) == side(c, a))
            << opening.mesh << " at (" << 1e3 * at.x << ", " << 1e3 * at.y << ") mm";
      });
    }
  }
}

TEST(VisualMeshes, AreDrawnByASoftwareRendererInTime) {
  const auto scenario = scene::LoadScenario(Scenarios() / "module_replacement");
  ASSERT_TRUE(scenario);
  std::size_t num_triangles = 0;
  for (const scene::Object& object : scenario->objects) {
    if (object.visual_mesh.empty()) continue;
    const auto mesh = vps::LoadTriangles(object.visual_mesh);
    ASSERT_TRUE(mesh);
    num_triangles += mesh->triangles.size();
  }
  EXPECT_LE(num_triangles, 250'000u);
}

}  // namespace
}  // namespace visual_node
