#include "view/appearance/split_sum.hpp"

#include <cmath>

namespace view {

// The mean over half vectors h that are distributed as the GGX distribution D (n.h): for l = reflect(v, h) the
// integrand F D V n.l, over the density D n.h / (4 v.h), is F V n.l 4 v.h / n.h. The points are a lattice with the
// golden ratio.
glm::vec2 SplitSum(double nv, double roughness) {
  constexpr int kNumSamples = 512;
  const double a = roughness * roughness;
  const glm::dvec3 v(std::sqrt(std::max(0.0, 1.0 - nv * nv)), 0.0, nv);
  double scale = 0.0, bias = 0.0;
  for (int i = 0; i < kNumSamples; ++i) {
    const double u = (i + 0.5) / kNumSamples, turn = 2.0 * std::acos(-1.0) * std::fmod(0.6180339887498949 * i, 1.0);
    const double cosine = std::sqrt((1.0 - u) / (1.0 + (a * a - 1.0) * u));
    const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    const glm::dvec3 h(sine * std::cos(turn), sine * std::sin(turn), cosine);
    const double vh = glm::dot(v, h), nl = 2.0 * vh * h.z - nv;
    if (nl <= 0.0 || vh <= 0.0) continue;
    const double visibility = 0.5 / glm::mix(2.0 * nl * nv, nl + nv, a);
    const double share = visibility * nl * 4.0 * vh / h.z, fresnel = std::pow(1.0 - vh, 5.0);
    scale += (1.0 - fresnel) * share;
    bias += fresnel * share;
  }
  return {scale / kNumSamples, bias / kNumSamples};
}

std::vector<glm::vec2> SplitSumTable() {
  std::vector<glm::vec2> table;
  for (int row = 0; row < kSplitSumSize; ++row) {
    for (int column = 0; column < kSplitSumSize; ++column) {
      table.push_back(SplitSum(std::max(1e-3, column / (kSplitSumSize - 1.0)), row / (kSplitSumSize - 1.0)));
    }
  }
  return table;
}

}  // namespace view
