#include "vps/oracle/triangle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vps/oracle/exact_distance.hpp"

namespace vps::oracle {
namespace {

// Does segment (p, q) pass through t? By the signs of the volumes spanned with t's edges.
bool SegmentMeetsTriangle(const glm::dvec3& p, const glm::dvec3& q, const Triangle& t) {
  const glm::dvec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
  const double a = glm::dot(p - t[0], n);
  const double b = glm::dot(q - t[0], n);
  if ((a > 0.0 && b > 0.0) || (a < 0.0 && b < 0.0) || a == b) return false;
  const glm::dvec3 x = p + (a / (a - b)) * (q - p);
  return glm::dot(glm::cross(t[1] - t[0], x - t[0]), n) >= 0.0 &&
         glm::dot(glm::cross(t[2] - t[1], x - t[1]), n) >= 0.0 && glm::dot(glm::cross(t[0] - t[2], x - t[2]), n) >= 0.0;
}

}  // namespace

// Minimise |p0 + s u - q0 - t v|^2 over s, t in [0, 1]: the unconstrained s first, then t for it, then s for the
// clamped t (Ericson 2005, section 5.1.9).
double SquaredSegmentDistance(const glm::dvec3& p0, const glm::dvec3& p1, const glm::dvec3& q0, const glm::dvec3& q1) {
  const glm::dvec3 u = p1 - p0;
  const glm::dvec3 v = q1 - q0;
  const glm::dvec3 w = p0 - q0;
  const double a = glm::dot(u, u);
  const double e = glm::dot(v, v);
  const double f = glm::dot(v, w);
  const double c = glm::dot(u, w);
  double s = 0.0;
  double t = 0.0;
  if (a <= 0.0 && e > 0.0) {
    t = std::clamp(f / e, 0.0, 1.0);
  } else if (a > 0.0 && e <= 0.0) {
    s = std::clamp(-c / a, 0.0, 1.0);
  } else if (a > 0.0 && e > 0.0) {
    const double b = glm::dot(u, v);
    const double d = a * e - b * b;
    if (d > 0.0) s = std::clamp((b * f - c * e) / d, 0.0, 1.0);
    t = (b * s + f) / e;
    if (t < 0.0) {
      t = 0.0;
      s = std::clamp(-c / a, 0.0, 1.0);
    } else if (t > 1.0) {
      t = 1.0;
      s = std::clamp((b - c) / a, 0.0, 1.0);
    }
  }
  const glm::dvec3 gap = w + s * u - t * v;
  return glm::dot(gap, gap);
}

// Ericson 2005, section 5.1.5.
glm::dvec3 NearestPointOnTriangle(const glm::dvec3& p, const Triangle& t) {
  const auto& [a, b, c] = t;
  const glm::dvec3 ab = b - a;
  const glm::dvec3 ac = c - a;
  const glm::dvec3 ap = p - a;
  const double d1 = glm::dot(ab, ap);
  const double d2 = glm::dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  const glm::dvec3 bp = p - b;
  const double d3 = glm::dot(ab, bp);
  const double d4 = glm::dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3) return a + (d1 / (d1 - d3)) * ab;
  const glm::dvec3 cp = p - c;
  const double d5 = glm::dot(ab, cp);
  const double d6 = glm::dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6) return a + (d2 / (d2 - d6)) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) return b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b);
  const double sum = va + vb + vc;
  if (!(sum > 0.0)) return ClosestPointOnTriangle(p, t);  // no area
  return a + (vb / sum) * ab + (vc / sum) * ac;
}

bool TrianglesMeet(const Triangle& s, const Triangle& t) {
  for (int i = 0; i < 3; ++i) {
    if (SegmentMeetsTriangle(s[i], s[(i + 1) % 3], t) || SegmentMeetsTriangle(t[i], t[(i + 1) % 3], s)) return true;
  }
  return false;
}

double TriangleDistance(const Triangle& s, const Triangle& t) {
  if (TrianglesMeet(s, t)) return 0.0;
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 p = s[i] - NearestPointOnTriangle(s[i], t);
    const glm::dvec3 q = t[i] - NearestPointOnTriangle(t[i], s);
    best = std::min({best, glm::dot(p, p), glm::dot(q, q)});
    for (int j = 0; j < 3; ++j) {
      best = std::min(best, SquaredSegmentDistance(s[i], s[(i + 1) % 3], t[j], t[(j + 1) % 3]));
    }
  }
  return std::sqrt(best);
}

}  // namespace vps::oracle
