#include "vps/mesh/thicken_sheet.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "vps/mesh/edge_table.hpp"

namespace vps {
namespace {

std::uint32_t Find(std::vector<std::uint32_t>* parent, std::uint32_t i) {
  while ((*parent)[i] != i) i = (*parent)[i] = (*parent)[(*parent)[i]];
  return i;
}

struct Seams {
  std::vector<std::uint32_t> corner_group;  // of corner 3 t + k: corners that move together
  std::vector<std::uint8_t> is_rim;         // of edge 3 t + k: no neighbour agrees there
};

Seams FindSeams(const TriangleMesh& sheet) {
  Seams seams;
  seams.corner_group.resize(3 * sheet.triangles.size());
  seams.is_rim.assign(3 * sheet.triangles.size(), 1);
  std::iota(seams.corner_group.begin(), seams.corner_group.end(), 0U);
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    const std::uint32_t root_a = Find(&seams.corner_group, a);
    const std::uint32_t root_b = Find(&seams.corner_group, b);
    seams.corner_group[std::max(root_a, root_b)] = std::min(root_a, root_b);
  };
  const std::vector<EdgeUse> edges = SortedEdges(sheet);
  for (std::size_t i = 0; i < edges.size();) {
    const std::size_t end = EndOfEdge(edges, i);
    const EdgeUse& a = edges[i];
    if (end - i == 2 && a.is_forward != edges[i + 1].is_forward) {
      const EdgeUse& b = edges[i + 1];
      seams.is_rim[3 * a.triangle + a.corner] = 0;
      seams.is_rim[3 * b.triangle + b.corner] = 0;
      join(3 * a.triangle + a.corner, 3 * b.triangle + (b.corner + 1) % 3);
      join(3 * a.triangle + (a.corner + 1) % 3, 3 * b.triangle + b.corner);
    }
    i = end;
  }
  for (std::uint32_t c = 0; c < seams.corner_group.size(); ++c) seams.corner_group[c] = Find(&seams.corner_group, c);
  return seams;
}

glm::dvec3 UnitNormal(const TriangleMesh& sheet, std::size_t triangle) {
  const auto [a, b, c] = sheet.corners(triangle);
  const glm::dvec3 n = glm::cross(b - a, c - a);
  const double length = glm::length(n);
  return length > 0.0 ? n / length : glm::dvec3(0.0);
}

// Per group, for half a thickness of 1: along the angle-weighted mean normal m, 1 / (m . n) of the face that leans
// most.
std::vector<glm::dvec3> Offsets(const TriangleMesh& sheet, const std::vector<std::uint32_t>& group) {
  std::vector<glm::dvec3> mean(group.size(), glm::dvec3(0.0));
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
    const auto p = sheet.corners(t);
    const glm::dvec3 n = UnitNormal(sheet, t);
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 u = p[(k + 1) % 3] - p[k];
      const glm::dvec3 v = p[(k + 2) % 3] - p[k];
      mean[group[3 * t + k]] += std::atan2(glm::length(glm::cross(u, v)), glm::dot(u, v)) * n;
    }
  }
  std::vector<double> lean(group.size(), 1.0);
  for (glm::dvec3& m : mean) m = glm::length(m) > 1e-9 ? glm::normalize(m) : glm::dvec3(0.0);
  for (std::size_t c = 0; c < group.size(); ++c) {
    const glm::dvec3 n = UnitNormal(sheet, c / 3);
    if (n != glm::dvec3(0.0)) lean[group[c]] = std::min(lean[group[c]], glm::dot(mean[group[c]], n));
  }
  for (std::size_t g = 0; g < mean.size(); ++g) mean[g] /= std::max(lean[g], 0.5);
  return mean;
}

}  // namespace

TriangleMesh ThickenSheet(const TriangleMesh& sheet, double thickness_m) {
  const Seams seams = FindSeams(sheet);
  const std::vector<glm::dvec3> offsets = Offsets(sheet, seams.corner_group);
  TriangleMesh solid;
  std::vector<std::uint32_t> upper(seams.corner_group.size());  // of a group; the lower one follows
  for (std::uint32_t c = 0; c < seams.corner_group.size(); ++c) {
    if (seams.corner_group[c] != c) continue;
    upper[c] = static_cast<std::uint32_t>(solid.vertices.size());
    const glm::dvec3& p = sheet.vertices[sheet.triangles[c / 3][c % 3]];
    solid.vertices.push_back(p + 0.5 * thickness_m * offsets[c]);
    solid.vertices.push_back(p - 0.5 * thickness_m * offsets[c]);
  }
  for (std::uint32_t t = 0; t < sheet.triangles.size(); ++t) {
    std::array<std::uint32_t, 3> u{};
    for (int k = 0; k < 3; ++k) u[k] = upper[seams.corner_group[3 * t + k]];
    solid.triangles.push_back(u);
    solid.triangles.push_back({u[2] + 1, u[1] + 1, u[0] + 1});
    for (int k = 0; k < 3; ++k) {
      if (seams.is_rim[3 * t + k] == 0) continue;
      const std::uint32_t a = u[k];
      const std::uint32_t b = u[(k + 1) % 3];
      solid.triangles.push_back({b, a, a + 1});
      solid.triangles.push_back({b, a + 1, b + 1});
    }
  }
  return solid;
}

}  // namespace vps
