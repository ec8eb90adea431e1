#pragma once

#include <glm/glm.hpp>

namespace vps {

struct OnTriangle {
  glm::dvec3 place{0.0};
  bool is_on_face = false;  // else on an edge or a corner
};

// The place of a triangle that is nearest to the origin; n across the triangle, of any length (Ericson 2005, 5.1.5).
inline OnTriangle NearestOnTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
                                    const glm::dvec3& n) {
  const glm::dvec3 ab = b - a;
  const glm::dvec3 ac = c - a;
  const double d1 = -glm::dot(ab, a);
  const double d2 = -glm::dot(ac, a);
  const double d3 = -glm::dot(ab, b);
  const double d4 = -glm::dot(ac, b);
  const double d5 = -glm::dot(ab, c);
  const double d6 = -glm::dot(ac, c);
  const double va = d3 * d6 - d5 * d4;
  const double vb = d5 * d2 - d1 * d6;
  const double vc = d1 * d4 - d3 * d2;
  if (d1 <= 0.0 && d2 <= 0.0) return {a};
  if (d3 >= 0.0 && d4 <= d3) return {b};
  if (d6 >= 0.0 && d5 <= d6) return {c};
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return {a + d1 / (d1 - d3) * ab};
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return {a + d2 / (d2 - d6) * ac};
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) return {b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b)};
  return {glm::dot(n, a) / glm::dot(n, n) * n, true};
}

}  // namespace vps
