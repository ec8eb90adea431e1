#include "vps/testing/shapes.hpp"

#include <cmath>
#include <numbers>

#include "vps/testing/quads.hpp"

namespace vps {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

}  // namespace

TriangleMesh MakeBox(const glm::dvec3& size_m) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back(0.5 * size_m * glm::dvec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  }
  AddQuad(&mesh, 0, 2, 3, 1);
  AddQuad(&mesh, 4, 5, 7, 6);
  AddQuad(&mesh, 0, 1, 5, 4);
  AddQuad(&mesh, 2, 6, 7, 3);
  AddQuad(&mesh, 0, 4, 6, 2);
  AddQuad(&mesh, 1, 3, 7, 5);
  return mesh;
}

TriangleMesh MakeSphere(double radius_m, int num_segments) {
  TriangleMesh mesh;
  const int num_rings = num_segments / 2;
  mesh.vertices.emplace_back(0, 0, radius_m);
  for (int i = 1; i < num_rings; ++i) {
    const double theta = std::numbers::pi * i / num_rings;
    for (int j = 0; j < num_segments; ++j) {
      const double phi = kTwoPi * j / num_segments;
      mesh.vertices.push_back(
          radius_m * glm::dvec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)));
    }
  }
  const auto south = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(0, 0, -radius_m);
  const auto at = [&](int ring, int segment) {
    return static_cast<std::uint32_t>(1 + (ring - 1) * num_segments + segment % num_segments);
  };
  for (int j = 0; j < num_segments; ++j) {
    mesh.triangles.push_back({0, at(1, j), at(1, j + 1)});
    mesh.triangles.push_back({south, at(num_rings - 1, j + 1), at(num_rings - 1, j)});
    for (int i = 1; i + 1 < num_rings; ++i) AddQuad(&mesh, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  }
  return mesh;
}

TriangleMesh MakeTorus(double major_m, double minor_m, int num_major, int num_minor) {
  TriangleMesh mesh;
  for (int i = 0; i < num_major; ++i) {
    const double u = kTwoPi * i / num_major;
    for (int j = 0; j < num_minor; ++j) {
      const double v = kTwoPi * j / num_minor;
      const double r = major_m + minor_m * std::cos(v);
      mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u), minor_m * std::sin(v));
    }
  }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>((i % num_major) * num_minor + j % num_minor); };
  for (int i = 0; i < num_major; ++i) {
    for (int j = 0; j < num_minor; ++j) AddQuad(&mesh, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  }
  return mesh;
}

TriangleMesh MakeCylinder(double radius_m, double length_m, int num_segments) {
  TriangleMesh mesh;
  for (const double z : {-0.5 * length_m, 0.5 * length_m}) {
    for (int i = 0; i < num_segments; ++i) {
      const double u = kTwoPi * i / num_segments;
      mesh.vertices.emplace_back(radius_m * std::cos(u), radius_m * std::sin(u), z);
    }
  }
  const auto n = static_cast<std::uint32_t>(num_segments);
  mesh.vertices.emplace_back(0, 0, -0.5 * length_m);
  mesh.vertices.emplace_back(0, 0, 0.5 * length_m);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    AddQuad(&mesh, i, j, n + j, n + i);
    mesh.triangles.push_back({2 * n, j, i});
    mesh.triangles.push_back({2 * n + 1, n + i, n + j});
  }
  return mesh;
}

TriangleMesh MakeBlockWithHole(double size_m, double height_m, double hole_radius_m, int num_segments) {
  // Rings of equal vertex count: hole (lower, upper) and block outline (lower, upper), joined by quads.
  const auto n = static_cast<std::uint32_t>((num_segments + 7) / 8 * 8);
  TriangleMesh mesh;
  const auto add_ring = [&](bool is_hole, double z) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const double u = kTwoPi * i / n;
      glm::dvec3 p(std::cos(u), std::sin(u), 0.0);
      p *= is_hole ? hole_radius_m : 0.5 * size_m / std::max(std::abs(p.x), std::abs(p.y));
      p.z = z;
      mesh.vertices.push_back(p);
    }
  };
  add_ring(true, -0.5 * height_m);
  add_ring(true, 0.5 * height_m);
  add_ring(false, -0.5 * height_m);
  add_ring(false, 0.5 * height_m);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    AddQuad(&mesh, i, n + i, n + j, j);                          // hole wall, normals towards the axis
    AddQuad(&mesh, 2 * n + i, 2 * n + j, 3 * n + j, 3 * n + i);  // outside
    AddQuad(&mesh, n + i, 3 * n + i, 3 * n + j, n + j);          // top
    AddQuad(&mesh, i, j, 2 * n + j, 2 * n + i);                  // bottom
  }
  return mesh;
}

TriangleMesh Joined(TriangleMesh mesh, const TriangleMesh& other, const glm::dvec3& shift_m) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const glm::dvec3& v : other.vertices) mesh.vertices.push_back(v + shift_m);
  for (const auto& t : other.triangles) mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  return mesh;
}

}  // namespace vps
