#pragma once

#include <glm/glm.hpp>
#include <limits>

#include "vps/coupling/nearest_point.hpp"

namespace vps {

// The rigid tool C on the hand D and the spring between them, which acts at the tool's centre of mass. No mass: the
// classic god object, whose wrench is what the contacts make.
struct GodObjectParameters {
  double stiffness_N_per_m = 2500.0;   // k_f
  double stiffness_Nm_per_rad = 30.0;  // k_t
  double period_s = 1e-3;
  double bounding_radius_m = 0.1;  // of the tool, about its centre of mass
  glm::dvec3 p_CoCm_C{0.0};
  double mass_kg = 0.0;
  glm::dmat3 I_Cm_C_kg_m2{0.0};
  // Of the damper between the tool and the device; a tool without mass has none.
  double most_damping_N_s_per_m = std::numeric_limits<double>::infinity();
  double most_damping_Nm_s_per_rad = std::numeric_limits<double>::infinity();
};

// A = M / T^2 + B / T + K of the tool about its centre of mass in its own axes, and the unit in which it is 1: with
// A = L L^T, y = L^T (x, phi) has |y|^2 = (x, phi)^T A (x, phi), and a row J of such motions becomes L^-1 J^T.
class ToolMetric {
 public:
  explicit ToolMetric(const GodObjectParameters& parameters);
  [[nodiscard]] Vector6 FromMotion(const glm::dvec3& x_C, const glm::dvec3& phi_C) const;
  [[nodiscard]] Vector6 FromRow(const glm::dvec3& n_C, const glm::dvec3& r_cross_n_C) const;
  void ToMotion(const Vector6& y, glm::dvec3* x_C, glm::dvec3* phi_C) const;
  [[nodiscard]] double damping_N_s_per_m() const { return damping_N_s_per_m_; }
  [[nodiscard]] double damping_Nm_s_per_rad() const { return damping_Nm_s_per_rad_; }

 private:
  double root_ = 1.0;      // of A's part for translations
  glm::dmat3 upper_{1.0};  // L^T of the part for rotations
  glm::dmat3 inverse_upper_{1.0};
  double damping_N_s_per_m_ = 0.0;
  double damping_Nm_s_per_rad_ = 0.0;
};

}  // namespace vps
