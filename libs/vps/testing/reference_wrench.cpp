#include "vps/testing/reference_wrench.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vps {

oracle::ContactWrench ReferenceWrench(const oracle::MeshDistance& A, const oracle::MeshDistance& B,
                                      const core::Pose& X_AB) {
  oracle::WrenchAccuracy accuracy;
  accuracy.relative = 3e-4;
  accuracy.max_pieces = 100'000;  // a long edge 1e-5 of its length deep would take minutes
  // A corner of a part 0.1 m long that is 1 um deep gives about 1e-15 of area times radius; a thousandth of a
  // thousandth of it is 1e-21.
  accuracy.floor = 1e-21;
  oracle::ContactWrench wrench = oracle::IntegrateContactWrench(A, B, X_AB, accuracy);
  wrench.has_converged |= wrench.error_bound_m3 <= accuracy.relative * wrench.depth_integral_m3;
  return wrench;
}

WrenchError CompareWrench(const glm::dvec3& force_A_m3, const glm::dvec3& moment_A_m4,
                          const oracle::ContactWrench& reference, double radius_B_m) {
  const double integral = reference.depth_integral_m3;
  WrenchError error;
  error.force = glm::distance(force_A_m3, reference.force_A_m3) / integral;
  error.moment = glm::distance(moment_A_m4, reference.moment_A_m4) / (integral * radius_B_m);
  error.direction_rad = std::numeric_limits<double>::quiet_NaN();
  if (glm::length(reference.force_A_m3) >= 0.1 * integral && glm::length(force_A_m3) > 0.0) {
    error.direction_rad = std::atan2(glm::length(glm::cross(force_A_m3, reference.force_A_m3)),
                                     glm::dot(force_A_m3, reference.force_A_m3));
  }
  return error;
}

double RadiusAboutOrigin_m(const TriangleMesh& mesh) {
  double radius_m = 0.0;
  for (const glm::dvec3& v : mesh.vertices) radius_m = std::max(radius_m, glm::length(v));
  return radius_m;
}

}  // namespace vps
