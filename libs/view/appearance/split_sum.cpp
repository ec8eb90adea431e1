#include "view/appearance/split_sum.hpp"

#include <array>
#include <cmath>

namespace view {
namespace {

constexpr std::size_t kNumSamples = 512;
using HalfVectors = std::array<glm::dvec3, kNumSamples>;

// Half vectors h that are distributed as the GGX distribution D (n.h): a lattice with the golden ratio.
HalfVectors HalfVectorsOf(double roughness) {
  const double a = roughness * roughness;
  HalfVectors halves;
  for (std::size_t i = 0; i < kNumSamples; ++i) {
    const auto number = static_cast<double>(i);
    const double u = (number + 0.5) / kNumSamples;
    const double turn = 2.0 * std::acos(-1.0) * std::fmod(0.6180339887498949 * number, 1.0);
    const double cosine = std::sqrt((1.0 - u) / (1.0 + (a * a - 1.0) * u));
    const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    halves[i] = {sine * std::cos(turn), sine * std::sin(turn), cosine};
  }
  return halves;
}

// The mean over the half vectors: for l = reflect(v, h) the integrand F D V n.l, over the density D n.h / (4 v.h), is
// F V n.l 4 v.h / n.h, with Schlick's F = (1 - v.h)^5.
glm::vec2 MeanOver(const HalfVectors& halves, double nv, double roughness) {
  const double a = roughness * roughness;
  const glm::dvec3 v(std::sqrt(std::max(0.0, 1.0 - nv * nv)), 0.0, nv);
  double scale = 0.0, bias = 0.0;
  for (const glm::dvec3& h : halves) {
    const double vh = v.x * h.x + v.z * h.z, nl = 2.0 * vh * h.z - nv;
    if (nl <= 0.0 || vh <= 0.0) continue;
    const double visibility = 0.5 / glm::mix(2.0 * nl * nv, nl + nv, a);
    const double miss = 1.0 - vh, fresnel = miss * miss * miss * miss * miss;
    const double share = visibility * nl * 4.0 * vh / h.z;
    scale += (1.0 - fresnel) * share;
    bias += fresnel * share;
  }
  return {scale / kNumSamples, bias / kNumSamples};
}

}  // namespace

glm::vec2 SplitSum(double nv, double roughness) {
  return MeanOver(HalfVectorsOf(roughness), nv, roughness);
}

// Every process that draws makes it at its start: the half vectors, which are most of the work, once for each row.
std::vector<glm::vec2> SplitSumTable() {
  std::vector<glm::vec2> table;
  for (int row = 0; row < kSplitSumSize; ++row) {
    const double roughness = row / (kSplitSumSize - 1.0);
    const HalfVectors halves = HalfVectorsOf(roughness);
    for (int column = 0; column < kSplitSumSize; ++column) {
      table.push_back(MeanOver(halves, std::max(1e-3, column / (kSplitSumSize - 1.0)), roughness));
    }
  }
  return table;
}

}  // namespace view
