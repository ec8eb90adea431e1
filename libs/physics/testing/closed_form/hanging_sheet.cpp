#include "physics/testing/closed_form/hanging_sheet.hpp"

#include <cmath>
#include <glm/glm.hpp>

namespace physics::closed_form {
namespace {

constexpr int kSteps = 400;

// Slope, curvature and sag at the free edge for a curvature at the wire.
glm::dvec3 Integrate(double L, double load, double curvature) {
  const auto rate = [&](double s, const glm::dvec3& y) {
    return glm::dvec3(y.y, -load * (L - s) * std::cos(y.x), std::sin(y.x));
  };
  glm::dvec3 y(0.0, curvature, 0.0);
  const double h = L / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    const double s = i * h;
    const glm::dvec3 k1 = rate(s, y);
    const glm::dvec3 k2 = rate(s + 0.5 * h, y + 0.5 * h * k1);
    const glm::dvec3 k3 = rate(s + 0.5 * h, y + 0.5 * h * k2);
    const glm::dvec3 k4 = rate(s + h, y + h * k3);
    y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return y;
}

}  // namespace

double HangingSheetSag_m(double half_m, double weight_N_per_m2, double bending_stiffness_Nm) {
  const double load = weight_N_per_m2 / bending_stiffness_Nm;
  // The curvature at the wire is at most that of a sheet that stays level, w L^2 / 2 D; with more the free edge would
  // still be curved.
  double low = 0.0;
  double high = 0.5 * load * half_m * half_m;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (Integrate(half_m, load, middle).y > 0.0 ? high : low) = middle;
  }
  return Integrate(half_m, load, 0.5 * (low + high)).z;
}

}  // namespace physics::closed_form
