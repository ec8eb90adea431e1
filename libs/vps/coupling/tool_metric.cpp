#include "vps/coupling/tool_metric.hpp"

#include <algorithm>
#include <cmath>

namespace vps {
namespace {

glm::dmat3 LowerCholesky(const glm::dmat3& a) {  // glm: [column][row]
  glm::dmat3 l(0.0);
  for (int j = 0; j < 3; ++j) {
    for (int i = j; i < 3; ++i) {
      double sum = a[j][i];
      for (int k = 0; k < j; ++k) sum -= l[k][i] * l[k][j];
      l[j][i] = i == j ? std::sqrt(sum) : sum / l[j][j];
    }
  }
  return l;
}

}  // namespace

ToolMetric::ToolMetric(const GodObjectParameters& parameters) {
  const double T = parameters.period_s;
  const double m = parameters.mass_kg;
  const glm::dmat3& I = parameters.I_Cm_C_kg_m2;
  // Critically damped, so that a tool with mass does not swing on its spring.
  damping_N_s_per_m_ = std::min(2.0 * std::sqrt(parameters.stiffness_N_per_m * m), parameters.most_damping_N_s_per_m);
  damping_Nm_s_per_rad_ =
      std::min(2.0 * std::sqrt(parameters.stiffness_Nm_per_rad * (I[0][0] + I[1][1] + I[2][2]) / 3.0),
               parameters.most_damping_Nm_s_per_rad);
  root_ = std::sqrt(m / (T * T) + damping_N_s_per_m_ / T + parameters.stiffness_N_per_m);
  const glm::dmat3 lower =
      LowerCholesky(I / (T * T) + glm::dmat3(damping_Nm_s_per_rad_ / T + parameters.stiffness_Nm_per_rad));
  upper_ = glm::transpose(lower);
  inverse_upper_ = glm::inverse(upper_);
}

Vector6 ToolMetric::FromMotion(const glm::dvec3& x_C, const glm::dvec3& phi_C) const {
  const glm::dvec3 x = root_ * x_C;
  const glm::dvec3 phi = upper_ * phi_C;
  return {x.x, x.y, x.z, phi.x, phi.y, phi.z};
}

Vector6 ToolMetric::FromRow(const glm::dvec3& n_C, const glm::dvec3& r_cross_n_C) const {
  const glm::dvec3 x = n_C / root_;
  const glm::dvec3 phi = r_cross_n_C * inverse_upper_;  // transposed: L^-1 times
  return {x.x, x.y, x.z, phi.x, phi.y, phi.z};
}

void ToolMetric::ToMotion(const Vector6& y, glm::dvec3* x_C, glm::dvec3* phi_C) const {
  *x_C = glm::dvec3(y[0], y[1], y[2]) / root_;
  *phi_C = inverse_upper_ * glm::dvec3(y[3], y[4], y[5]);
}

}  // namespace vps
