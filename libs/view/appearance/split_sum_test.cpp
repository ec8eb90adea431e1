#include "view/appearance/split_sum.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace view {
namespace {

// Integrates D F V n.l over all light directions on a fine grid, without knowing where the lobe is.
double Reflected(double nv, double roughness, double f0) {
  const double a = roughness * roughness, pi = std::acos(-1.0);
  const glm::dvec3 v(std::sqrt(1.0 - nv * nv), 0.0, nv);
  constexpr int kHeights = 500, kTurns = 500;
  double sum = 0.0;
  for (int i = 0; i < kHeights; ++i) {
    const double nl = (i + 0.5) / kHeights, ring = std::sqrt(1.0 - nl * nl);
    for (int k = 0; k < kTurns; ++k) {
      const double turn = 2.0 * pi * (k + 0.5) / kTurns;
      const glm::dvec3 l(ring * std::cos(turn), ring * std::sin(turn), nl), h = glm::normalize(l + v);
      const double q = h.z * h.z * (a * a - 1.0) + 1.0, fresnel = f0 + (1.0 - f0) * std::pow(1.0 - glm::dot(h, v), 5.0);
      sum += a * a / (pi * q * q) * fresnel * 0.5 / glm::mix(2.0 * nl * nv, nl + nv, a) * nl;
    }
  }
  return sum * 2.0 * pi / (static_cast<double>(kHeights) * kTurns);
}

TEST(SplitSum, IsWhatTheShadersDistributionReflectsOfWhiteLightFromEverywhere) {
  for (const double roughness : {0.3, 0.6, 1.0}) {
    for (const double nv : {0.2, 0.5, 0.95}) {
      const glm::vec2 split = SplitSum(nv, roughness);
      for (const double f0 : {0.04, 1.0}) {
        EXPECT_NEAR(f0 * split.x + split.y, Reflected(nv, roughness, f0), 0.006) << nv << " " << roughness << " " << f0;
      }
    }
  }
}

TEST(SplitSum, ASmoothMirrorReflectsAll) {
  for (const double nv : {0.2, 0.6, 1.0}) {
    const glm::vec2 split = SplitSum(nv, 0.02);
    EXPECT_NEAR(split.x + split.y, 1.0, 2e-3);
  }
}

}  // namespace
}  // namespace view
