#pragma once

#include <algorithm>
#include <cmath>

#include "vps/surface/surface_tree.hpp"

namespace vps {

// A symmetric matrix as six numbers (SurfaceNode::spread_m4) times a vector.
inline glm::vec3 Times(const std::array<float, 6>& S, const glm::vec3& v) {
  return {S[0] * v.x + S[3] * v.y + S[4] * v.z, S[3] * v.x + S[1] * v.y + S[5] * v.z,
          S[4] * v.x + S[5] * v.y + S[2] * v.z};
}
// Trace of the product of two of them.
inline float TraceOf(const std::array<float, 6>& S, const std::array<float, 6>& T) {
  return S[0] * T[0] + S[1] * T[1] + S[2] * T[2] + 2.0f * (S[3] * T[3] + S[4] * T[4] + S[5] * T[5]);
}

// Integrals of max(depth, 0) over a node whose depth is d + g . e, with d [m] in the mean and the slope g.
//
// The depth's values have the mean d and the variance v = g^T Q g / a. They are taken as spread evenly over [d - w, d +
// w], w = sqrt(3 v): exact where the whole node is inside, for which d >= w is taken, or outside, and right in the mean
// over all d where it straddles the surface, since the integral over d of (mean of positive part - max(d, 0)) is v / 2
// for any distribution with that variance. With s = g . e:
//
//   m1 = mean of max(d + s, 0)   = d,              (d + w)^2 / (4 w),                            0
//   m2 = mean of its square      = d^2 + w^2 / 3,  (d + w)^3 / (6 w),                            0
//   k  = mean of max(d + s, 0) s
//        over w^2 / 3            = 1,              (d w^2 / 2 + w^3 / 3 - d^3 / 6) / (2 w^3 / 3),  0
//
// for d >= w, between, and d <= -w. Then
//
//   force            F = A m1 + k N g
//   moment about c   M = t m1 + k (Q g) x n,   t = integral of e x n dA, from N;   n = A / |A|
//
// M's second part is exact where the node is flat.
struct NodeIntegral {
  NodeIntegral() = default;
  NodeIntegral(const SurfaceNode& node, float depth_m, const glm::vec3& slope) {
    const glm::vec3 Qg = Times(node.spread_m4, slope);
    const float variance = std::max(0.0f, glm::dot(slope, Qg) / node.area_m2);
    half_width_m = std::min(node.radius_m, std::sqrt(3.0f * variance));
    const float d = depth_m;
    const float w = half_width_m;
    if (d <= -w) return;
    float share = 1.0f;
    if (d >= w) {
      mean_m = d;
      mean_square_m2 = d * d + w * w / 3.0f;
    } else {
      const float u = d + w;
      mean_m = u * u / (4.0f * w);
      mean_square_m2 = u * u * u / (6.0f * w);
      share = (d * w * w / 2.0f + w * w * w / 3.0f - d * d * d / 6.0f) / (2.0f * w * w * w / 3.0f);
    }
    const glm::mat3& N = node.normal_moment_m3;
    force_m3 = node.area_vector_m2 * mean_m + share * (N * slope);
    const float length = glm::length(node.area_vector_m2);
    const glm::vec3 n = length > 0.0f ? node.area_vector_m2 / length : glm::vec3(0.0f);
    const glm::vec3 t(N[1].z - N[2].y, N[2].x - N[0].z, N[0].y - N[1].x);
    moment_m4 = t * mean_m + share * glm::cross(Qg, n);
  }

  float half_width_m = 0.0f;    // w
  float mean_m = 0.0f;          // m1
  float mean_square_m2 = 0.0f;  // m2
  glm::vec3 force_m3{0.0f};
  glm::vec3 moment_m4{0.0f};  // about the node's centre
};

}  // namespace vps
