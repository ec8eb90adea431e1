#include "vps/oracle/mesh_distance.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

namespace vps::oracle {
namespace {

constexpr std::uint32_t kLeafTriangles = 4;  // not derived; results do not depend on it

double SquaredDistanceToBox(const glm::dvec3& p, const glm::dvec3& lower, const glm::dvec3& upper) {
  const glm::dvec3 gap = glm::max(glm::max(lower - p, p - upper), glm::dvec3(0.0));
  return glm::dot(gap, gap);
}

// Solid angle of t seen from p (van Oosterom and Strackee 1983).
double SolidAngle(const glm::dvec3& p, const Triangle& t) {
  const glm::dvec3 a = t[0] - p;
  const glm::dvec3 b = t[1] - p;
  const glm::dvec3 c = t[2] - p;
  const double la = glm::length(a);
  const double lb = glm::length(b);
  const double lc = glm::length(c);
  return 2.0 * std::atan2(glm::dot(a, glm::cross(b, c)),
                          la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
}

glm::dvec3 Centroid(const Triangle& t) {
  return (t[0] + t[1] + t[2]) / 3.0;
}

bool ShareACorner(const Triangle& s, const Triangle& t) {
  for (const glm::dvec3& a : s) {
    for (const glm::dvec3& b : t) {
      if (a == b) return true;
    }
  }
  return false;
}

}  // namespace

MeshDistance::MeshDistance(const TriangleMesh& mesh, Sides sides) : sides_(sides) {
  std::vector<std::uint32_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0U);
  nodes_.reserve(mesh.triangles.size());
  nodes_.emplace_back();
  nodes_[0].count = static_cast<std::uint32_t>(order.size());
  Build(0, mesh, &order);
  triangles_.reserve(order.size());
  for (const std::uint32_t i : order) triangles_.push_back(mesh.corners(i));
  FindParts(mesh);
  is_simple_solid_ = sides == Sides::kSolid && IsSimpleSolid(mesh);
  if (is_simple_solid_) ComputeNormals(mesh, order);
}

void MeshDistance::FindParts(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> part(mesh.vertices.size());
  std::iota(part.begin(), part.end(), 0U);
  const auto root = [&](std::uint32_t v) {
    while (part[v] != v) v = part[v] = part[part[v]];
    return v;
  };
  for (const auto& t : mesh.triangles) {
    part[root(t[1])] = root(t[0]);
    part[root(t[2])] = root(t[0]);
  }
  std::vector<bool> is_known(mesh.vertices.size(), false);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle t = mesh.corners(i);
    const std::uint32_t r = root(mesh.triangles[i][0]);
    if (is_known[r] || glm::length(glm::cross(t[1] - t[0], t[2] - t[0])) <= 0.0) continue;
    is_known[r] = true;
    part_corners_.push_back(t[0]);
    part_centroids_.push_back(Centroid(t));
  }
}

// Whether every face has winding number 1 on its inner and 0 on its outer side: the mesh is closed, no triangle meets
// one that shares no corner with it, and each connected part winds half a time around a point of its own surface (the
// mean of both sides).
bool MeshDistance::IsSimpleSolid(const TriangleMesh& mesh) const {
  if (CountOpenEdges(mesh) != 0) return false;
  for (const glm::dvec3& c : part_centroids_) {
    if (std::abs(WindingNumber(c) - 0.5) > 0.1) return false;
  }
  return std::none_of(triangles_.begin(), triangles_.end(), [this](const Triangle& t) { return Meets(t, true); });
}

// Baerentzen and Aanaes 2005: with the sum m of the faces' normals around the nearest edge or corner q, at a corner
// weighted by the faces' angles there, the sign of m . (p - q) is right for inside and outside, as a face's normal is.
void MeshDistance::ComputeNormals(const TriangleMesh& mesh, const std::vector<std::uint32_t>& order) {
  std::vector<glm::dvec3> corner(mesh.vertices.size(), glm::dvec3(0.0));
  std::map<std::pair<std::uint32_t, std::uint32_t>, glm::dvec3> edge;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle t = mesh.corners(i);
    const glm::dvec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
    if (glm::length(n) <= 0.0) continue;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = mesh.triangles[i][k];
      const std::uint32_t w = mesh.triangles[i][(k + 1) % 3];
      const glm::dvec3 a = glm::normalize(t[(k + 1) % 3] - t[k]);
      const glm::dvec3 b = glm::normalize(t[(k + 2) % 3] - t[k]);
      corner[v] += std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0)) * glm::normalize(n);
      edge[std::minmax(v, w)] += glm::normalize(n);
    }
  }
  for (const std::uint32_t i : order) {
    Normals& normals = normals_.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = mesh.triangles[i][k];
      normals.corner[k] = corner[v];
      normals.edge[k] = edge[std::minmax(v, mesh.triangles[i][(k + 1) % 3])];
    }
  }
}

// Halves at the median centroid along the longest side of the box.
void MeshDistance::Build(std::uint32_t index, const TriangleMesh& mesh, std::vector<std::uint32_t>* order) {
  Node node = nodes_[index];
  const auto begin = order->begin() + node.first;
  const auto end = begin + node.count;
  node.lower_m = glm::dvec3(std::numeric_limits<double>::infinity());
  node.upper_m = -node.lower_m;
  double area = 0.0;
  glm::dvec3 weighted(0.0);
  for (auto i = begin; i != end; ++i) {
    const Triangle t = mesh.corners(*i);
    for (const glm::dvec3& v : t) {
      node.lower_m = glm::min(node.lower_m, v);
      node.upper_m = glm::max(node.upper_m, v);
    }
    const glm::dvec3 normal = 0.5 * glm::cross(t[1] - t[0], t[2] - t[0]);
    node.dipole_m2 += normal;
    area += glm::length(normal);
    weighted += glm::length(normal) * Centroid(t);
  }
  node.centre_m = area > 0.0 ? weighted / area : 0.5 * (node.lower_m + node.upper_m);
  for (auto i = begin; i != end; ++i) {
    for (const glm::dvec3& v : mesh.corners(*i))
      node.radius_m = std::max(node.radius_m, glm::distance(v, node.centre_m));
  }
  if (node.count > kLeafTriangles) {
    const glm::dvec3 size = node.upper_m - node.lower_m;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    const std::uint32_t half = node.count / 2;
    const auto place = [&](std::uint32_t i) {
      const Triangle t = mesh.corners(i);
      return t[0][axis] + t[1][axis] + t[2][axis];
    };
    std::nth_element(begin, begin + half, end, [&](std::uint32_t a, std::uint32_t b) {
      return std::pair{place(a), a} < std::pair{place(b), b};
    });
    node.left = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    nodes_.emplace_back();
    nodes_[node.left].first = node.first;
    nodes_[node.left].count = half;
    nodes_[node.left + 1].first = node.first + half;
    nodes_[node.left + 1].count = node.count - half;
  }
  nodes_[index] = node;
  if (node.left != 0) {
    Build(node.left, mesh, order);
    Build(node.left + 1, mesh, order);
  }
}

std::optional<MeshDistance::Nearest> MeshDistance::FindNearest(const glm::dvec3& p, double limit_m) const {
  Nearest best;
  double best_squared = limit_m * limit_m;
  bool is_found = false;
  struct Entry {
    std::uint32_t node;
    double squared;
  };
  Entry stack[128];
  int depth = 0;
  stack[depth++] = {0, SquaredDistanceToBox(p, nodes_[0].lower_m, nodes_[0].upper_m)};
  while (depth > 0) {
    const Entry entry = stack[--depth];
    if (entry.squared >= best_squared) continue;
    const Node& node = nodes_[entry.node];
    if (node.left == 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        const glm::dvec3 q = NearestPointOnTriangle(p, triangles_[i]);
        const double squared = glm::dot(p - q, p - q);
        if (squared < best_squared) {
          best_squared = squared;
          best.triangle = i;
          best.point_m = q;
          is_found = true;
        }
      }
      continue;
    }
    const Node& a = nodes_[node.left];
    const Node& b = nodes_[node.left + 1];
    const Entry first{node.left, SquaredDistanceToBox(p, a.lower_m, a.upper_m)};
    const Entry second{node.left + 1, SquaredDistanceToBox(p, b.lower_m, b.upper_m)};
    const bool is_first_nearer = first.squared <= second.squared;
    stack[depth++] = is_first_nearer ? second : first;
    stack[depth++] = is_first_nearer ? first : second;
  }
  if (!is_found) return std::nullopt;
  best.distance_m = std::sqrt(best_squared);
  return best;
}

double MeshDistance::UnsignedDistance(const glm::dvec3& p) const {
  const auto nearest = FindNearest(p);
  return nearest ? nearest->distance_m : std::numeric_limits<double>::infinity();
}

double MeshDistance::WindingNumber(const glm::dvec3& p) const {
  double sum = 0.0;
  for (const Triangle& t : triangles_) sum += SolidAngle(p, t);
  return sum / (4.0 * std::numbers::pi);
}

// Solid angle of a far group of triangles as one dipole at its centre: sum(area n) . r / |r|^3 (Barill et al. 2018,
// first order). From 2.5 radii on, not derived: IsInside allows for an error of 0.3 and takes the exact sum nearer to
// 0.5.
double MeshDistance::FarFieldWinding(const glm::dvec3& p) const {
  constexpr double kFar = 2.5;
  double sum = 0.0;
  std::uint32_t stack[128];
  int depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const Node& node = nodes_[stack[--depth]];
    const glm::dvec3 r = node.centre_m - p;
    const double distance = glm::length(r);
    if (distance > kFar * node.radius_m) {
      sum += glm::dot(node.dipole_m2, r) / (distance * distance * distance);
    } else if (node.left == 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) sum += SolidAngle(p, triangles_[i]);
    } else {
      stack[depth++] = node.left;
      stack[depth++] = node.left + 1;
    }
  }
  return sum / (4.0 * std::numbers::pi);
}

// On a simple solid the normal of the nearest face, edge or corner gives the same sign as the winding number.
bool MeshDistance::IsInside(const glm::dvec3& p, const Nearest& nearest) const {
  if (sides_ == Sides::kSheet) return false;
  if (!is_simple_solid_) return IsInside(p);
  const Triangle& t = triangles_[nearest.triangle];
  const glm::dvec3& q = nearest.point_m;
  const glm::dvec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
  const double n2 = glm::dot(n, n);
  if (!(n2 > 0.0)) return IsInside(p);
  // Is the nearest point on the edge from corner k to k + 1? By the share of the triangle's area beside that edge.
  bool is_on[3];
  int num_on = 0;
  for (int k = 0; k < 3; ++k) {
    is_on[k] = glm::dot(glm::cross(t[(k + 1) % 3] - t[k], q - t[k]), n) < 1e-9 * n2;
    num_on += is_on[k] ? 1 : 0;
  }
  glm::dvec3 outward = n;
  for (int k = 0; k < 3; ++k) {
    if (num_on == 1 && is_on[k]) outward = normals_[nearest.triangle].edge[k];
    if (num_on >= 2 && is_on[k] && is_on[(k + 2) % 3]) outward = normals_[nearest.triangle].corner[k];
  }
  return glm::dot(p - q, outward) < 0.0;
}

bool MeshDistance::IsInside(const glm::dvec3& p) const {
  if (sides_ == Sides::kSheet) return false;
  // The approximation is used where it is far from the threshold, the exact sum near it.
  const double winding = FarFieldWinding(p);
  return std::abs(winding - 0.5) < 0.3 ? WindingNumber(p) > 0.5 : winding > 0.5;
}

double MeshDistance::SignedDistance(const glm::dvec3& p) const {
  const auto nearest = FindNearest(p);
  if (!nearest) return std::numeric_limits<double>::infinity();
  return IsInside(p, *nearest) ? -nearest->distance_m : nearest->distance_m;
}

bool MeshDistance::Meets(const Triangle& t, bool skip_neighbours) const {
  const glm::dvec3 lower = glm::min(t[0], glm::min(t[1], t[2]));
  const glm::dvec3 upper = glm::max(t[0], glm::max(t[1], t[2]));
  std::uint32_t stack[128];
  int depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const Node& node = nodes_[stack[--depth]];
    if (glm::any(glm::lessThan(upper, node.lower_m)) || glm::any(glm::lessThan(node.upper_m, lower))) continue;
    if (node.left == 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        if (skip_neighbours && ShareACorner(t, triangles_[i])) continue;
        if (TrianglesMeet(t, triangles_[i])) return true;
      }
      continue;
    }
    stack[depth++] = node.left;
    stack[depth++] = node.left + 1;
  }
  return false;
}

}  // namespace vps::oracle
