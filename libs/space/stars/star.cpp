#include "space/stars/star.hpp"

#include <algorithm>
#include <cmath>

namespace space {
namespace {

constexpr double kMagnitude0_cd_per_m2 = 10.8e4;
constexpr double kSquareArcSecondsPerSr = 4.25451703e10;

// CIE 1931 chromaticity of a black body, 1667 K to 25000 K [Kim et al. 2002].
glm::dvec2 PlanckianLocus(double T_K) {
  const double t = 1e3 / T_K;
  const double x = T_K < 4000.0 ? ((-0.2661239 * t - 0.2343589) * t + 0.8776956) * t + 0.179910
                                : ((-3.0258469 * t + 2.1070379) * t + 0.2226347) * t + 0.240390;
  double y = 0.0;
  if (T_K < 2222.0) {
    y = ((-1.1063814 * x - 1.34811020) * x + 2.18555832) * x - 0.20219683;
  } else if (T_K < 4000.0) {
    y = ((-0.9549476 * x - 1.37418593) * x + 2.09137015) * x - 0.16748867;
  } else {
    y = ((3.0817580 * x - 5.87338670) * x + 3.75112997) * x - 0.37001483;
  }
  return {x, y};
}

}  // namespace

double Illuminance_lx(double magnitude) {
  return kMagnitude0_cd_per_m2 / kSquareArcSecondsPerSr * std::pow(10.0, -0.4 * magnitude);
}

glm::dvec3 ColorOf(double color_bv) {
  const double bv = std::clamp(color_bv, -0.4, 2.0);
  const double T_K = 4600.0 * (1.0 / (0.92 * bv + 1.7) + 1.0 / (0.92 * bv + 0.62));
  const glm::dvec2 xy = PlanckianLocus(std::clamp(T_K, 1667.0, 25000.0));
  const glm::dvec3 xyz(xy.x / xy.y, 1.0, (1.0 - xy.x - xy.y) / xy.y);
  const glm::dvec3 rgb(3.2404542 * xyz.x - 1.5371385 * xyz.y - 0.4985314 * xyz.z,
                       -0.9692660 * xyz.x + 1.8760108 * xyz.y + 0.0415560 * xyz.z,
                       0.0556434 * xyz.x - 0.2040259 * xyz.y + 1.0572252 * xyz.z);
  const glm::dvec3 inside = glm::max(rgb, glm::dvec3(0.0));  // red stars lie outside the triangle of the primaries
  return inside / glm::dot(inside, glm::dvec3(0.2126729, 0.7151522, 0.0721750));
}

}  // namespace space
