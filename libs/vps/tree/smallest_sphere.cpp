#include <array>
#include <cmath>

#include "vps/tree/build_tree.hpp"

namespace vps {
namespace {

// Sphere through all of 1 to 4 points with its centre in their affine hull; false when they are degenerate.
// Centre c = p0 + sum_k u_k d_k with d_k = p_k - p0 and |c - p_k| = |c - p0|, that is 2 d_k . (c - p0) = d_k . d_k:
// a linear system in u with the Gram matrix of the d_k.
bool Circumsphere(const glm::dvec3* points, int count, Sphere* sphere) {
  const int n = count - 1;
  double a[3][4] = {};
  glm::dvec3 d[3];
  for (int i = 0; i < n; ++i) d[i] = points[i + 1] - points[0];
  double scale = 0.0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) a[i][j] = 2.0 * glm::dot(d[i], d[j]);
    a[i][3] = glm::dot(d[i], d[i]);
    scale = std::max(scale, a[i][i]);
  }
  for (int i = 0; i < n; ++i) {
    int pivot = i;
    for (int r = i + 1; r < n; ++r) {
      if (std::abs(a[r][i]) > std::abs(a[pivot][i])) pivot = r;
    }
    if (!(std::abs(a[pivot][i]) > 1e-13 * scale)) return false;
    std::swap(a[i], a[pivot]);
    for (int r = 0; r < n; ++r) {
      if (r == i) continue;
      const double f = a[r][i] / a[i][i];
      for (int c = i; c < 4; ++c) a[r][c] -= f * a[i][c];
    }
  }
  glm::dvec3 offset(0.0);
  for (int i = 0; i < n; ++i) offset += a[i][3] / a[i][i] * d[i];
  *sphere = {points[0] + offset, glm::length(offset)};
  return true;
}

// Smallest sphere of at most five points, by trying every set of up to four as its support.
Sphere SmallestOfFew(const std::array<glm::dvec3, 5>& points, int count, std::array<glm::dvec3, 5>* support,
                     int* num_support) {
  Sphere best;
  best.radius = INFINITY;
  for (int mask = 1; mask < 1 << count; ++mask) {
    std::array<glm::dvec3, 5> chosen;
    int n = 0;
    for (int i = 0; i < count; ++i) {
      if (mask >> i & 1) chosen[n++] = points[i];
    }
    Sphere sphere;
    if (n > 4 || !Circumsphere(chosen.data(), n, &sphere) || sphere.radius >= best.radius) continue;
    bool holds_all = true;
    for (int i = 0; i < count; ++i) {
      holds_all &= glm::length(points[i] - sphere.centre) <= sphere.radius * (1.0 + 1e-10) + 1e-15;
    }
    if (!holds_all) continue;
    best = sphere;
    *support = chosen;
    *num_support = n;
  }
  return best;
}

}  // namespace

Sphere SmallestSphere(const float* x, const float* y, const float* z, std::size_t count) {
  if (count == 0) return {};
  // The smallest sphere is fixed by at most four support points. Add the farthest point that is still outside, solve
  // the at most five points exactly, repeat: the radius grows each time, so this ends, at the smallest sphere.
  std::array<glm::dvec3, 5> support{};
  int num_support = 1;
  support[0] = {x[0], y[0], z[0]};
  Sphere sphere{support[0], 0.0};
  for (int iteration = 0; iteration < 1000; ++iteration) {
    double farthest = 0.0;
    std::size_t index = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const glm::dvec3 r = glm::dvec3(x[i], y[i], z[i]) - sphere.centre;
      const double squared = glm::dot(r, r);
      if (squared > farthest) {
        farthest = squared;
        index = i;
      }
    }
    if (std::sqrt(farthest) <= sphere.radius * (1.0 + 1e-9)) break;
    support[num_support] = {x[index], y[index], z[index]};
    const std::array<glm::dvec3, 5> points = support;
    int next_support = 0;
    const Sphere next = SmallestOfFew(points, num_support + 1, &support, &next_support);
    if (!(next.radius > sphere.radius) || !std::isfinite(next.radius)) break;  // only rounding is left to gain
    sphere = next;
    num_support = next_support;
  }
  return sphere;
}

Sphere SmallestSphere(std::span<const glm::vec3> points) {
  std::vector<float> axes[3];
  for (const glm::vec3& p : points) {
    for (int i = 0; i < 3; ++i) axes[i].push_back(p[i]);
  }
  return SmallestSphere(axes[0].data(), axes[1].data(), axes[2].data(), points.size());
}

}  // namespace vps
