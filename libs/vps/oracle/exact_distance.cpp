#include "vps/oracle/exact_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace vps::oracle {
namespace {

glm::dvec3 ClosestPointOnSegment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 ab = b - a;
  const double squared = glm::dot(ab, ab);
  const double s = squared > 0.0 ? std::clamp(glm::dot(p - a, ab) / squared, 0.0, 1.0) : 0.0;
  return a + s * ab;
}

}  // namespace

// The foot of the perpendicular when it lies inside the triangle, else the nearest point of the three edges. Inside is
// decided by the signs of the three sub-triangles' areas along the normal.
glm::dvec3 ClosestPointOnTriangle(const glm::dvec3& p, const std::array<glm::dvec3, 3>& t) {
  const glm::dvec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
  const double n2 = glm::dot(n, n);
  if (n2 > 0.0) {
    const bool is_inside = glm::dot(glm::cross(t[1] - t[0], p - t[0]), n) >= 0.0 &&
                           glm::dot(glm::cross(t[2] - t[1], p - t[1]), n) >= 0.0 &&
                           glm::dot(glm::cross(t[0] - t[2], p - t[2]), n) >= 0.0;
    if (is_inside) return p - (glm::dot(p - t[0], n) / n2) * n;
  }
  glm::dvec3 best = ClosestPointOnSegment(p, t[0], t[1]);
  for (const auto& [i, j] : {std::pair{1, 2}, std::pair{2, 0}}) {
    const glm::dvec3 q = ClosestPointOnSegment(p, t[i], t[j]);
    if (glm::distance(p, q) < glm::distance(p, best)) best = q;
  }
  return best;
}

ExactDistance::ExactDistance(const TriangleMesh& mesh) {
  triangles_.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) triangles_.push_back(mesh.corners(i));
}

double ExactDistance::UnsignedDistance(const glm::dvec3& p) const {
  double best = std::numeric_limits<double>::infinity();
  for (const auto& t : triangles_) best = std::min(best, glm::distance(p, ClosestPointOnTriangle(p, t)));
  return best;
}

// Sum of the triangles' solid angles over 4 pi. With a, b, c from p to the corners (van Oosterom and Strackee 1983):
// tan(omega / 2) = a . (b x c) / (|a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|).
double ExactDistance::WindingNumber(const glm::dvec3& p) const {
  double sum = 0.0;
  for (const auto& t : triangles_) {
    const glm::dvec3 a = t[0] - p;
    const glm::dvec3 b = t[1] - p;
    const glm::dvec3 c = t[2] - p;
    const double la = glm::length(a);
    const double lb = glm::length(b);
    const double lc = glm::length(c);
    sum += 2.0 * std::atan2(glm::dot(a, glm::cross(b, c)),
                            la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return sum / (4.0 * std::numbers::pi);
}

double ExactDistance::SignedDistance(const glm::dvec3& p) const {
  const double distance = UnsignedDistance(p);
  return WindingNumber(p) > 0.5 ? -distance : distance;
}

}  // namespace vps::oracle
