#include "vps/coupling/virtual_coupling.hpp"

#include <algorithm>
#include <array>
#include <span>

namespace vps {
namespace {

// Gauss-Seidel sweeps, three times the 20 of a peg in a hole, and when they end: at 2.5 uN with the default stiffness.
// Tests pass from 20 to 300 and from 1e-11 to 1e-7; more sweeps cost time in contacts that contradict each other.
constexpr int kMaxIterations = 60;
constexpr double kConvergence_m = 1e-9;

// Small rigid motion: translation [m] and rotation vector [rad], in W.
struct Motion {
  glm::dvec3 translation_m{0.0};
  glm::dvec3 rotation_rad{0.0};
};

core::Pose Moved(const core::Pose& X_WC, const Motion& motion) {
  return {glm::normalize(core::QuaternionFromRotationVector(motion.rotation_rad) * X_WC.rotation),
          X_WC.translation + motion.translation_m};
}

// One plane: the normal motion of its contact point, n . (x + phi x r) = n . x + (r x n) . phi, is at least the bound.
struct Row {
  glm::dvec3 n;
  glm::dvec3 r_cross_n;
  double bound_m = 0.0;
  double effective_mass = 0.0;  // 1 / (J M^-1 J^T)
  double multiplier = 0.0;
};

// min 1/2 |x - x_d|^2 + 1/2 sigma |phi - phi_d|^2  subject to  J_i (x, phi) >= bound_i, by projected Gauss-Seidel on
// the multipliers: stationarity gives (x, phi) = (x_d, phi_d) + M^-1 J^T l with M = diag(1, sigma), l >= 0 and
// complementary, so each sweep adds to l_i what plane i still lacks and clips it at zero.
Motion ProjectOntoPlanes(Motion motion, std::span<Row> rows, double sigma_m2) {
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    double largest_change_m = 0.0;
    for (Row& row : rows) {
      const double reached_m = glm::dot(row.n, motion.translation_m) + glm::dot(row.r_cross_n, motion.rotation_rad);
      const double wanted = row.multiplier + (row.bound_m - reached_m) * row.effective_mass;
      const double change = std::max(wanted, 0.0) - row.multiplier;
      row.multiplier += change;
      motion.translation_m += change * row.n;
      motion.rotation_rad += (change / sigma_m2) * row.r_cross_n;
      largest_change_m = std::max(largest_change_m, std::abs(change));
    }
    if (largest_change_m < kConvergence_m) break;
  }
  return motion;
}

}  // namespace

// Eq. 4 as printed,  dphi = t/|t| (sigma |f|/|t| + |t|/|f|)^-1  and  dx = f/|f| sigma |f|/|t| |dphi|,  divides by |t|
// and |f|. Multiply numerator and denominator of the bracket by |f||t|:
//   (sigma |f|/|t| + |t|/|f|)^-1 = |f||t| / (sigma |f|^2 + |t|^2)
//   dphi = t |f| / (sigma |f|^2 + |t|^2),        dx = f sigma |f| / (sigma |f|^2 + |t|^2).
// Only f = t = 0 is left to guard. Dimensions with f [m], t [m^2], sigma [m^2]: dphi [1/m], dx [1]; times the
// penetration [m] of Eq. 3 that is [rad] and [m]. Bounds: |dx| <= 1, |dphi| <= 1/(2 sqrt(sigma)).
SeparationStep ComputeSeparationStep(const PenetrationSum& f, double sigma_m2) {
  const double norm_f = glm::length(f.sum_m);
  const double denominator = sigma_m2 * norm_f * norm_f + glm::dot(f.moment_m2, f.moment_m2);
  if (!(denominator > 0.0)) return {};
  return {(sigma_m2 * norm_f / denominator) * f.sum_m, (norm_f / denominator) * f.moment_m2};
}

// (1) C moves out of penetration by Eq. 3-4, (2) C moves towards D as far as the planes allow: the paper's "projection
// of the resultant pose on the VPS forces and torques".
core::Wrench VirtualCoupling::Step(const core::Pose& X_WD, const CouplingContact& contact) {
  const CouplingParameters& p = parameters_;

  // (1) Down to the rest depth p0: at V = 0 contact would be lost, the proxy jump back to D and the force be a
  // saw-tooth.
  Motion out;
  if (contact.is_in_contact && contact.deepest_excess_m > 0.0) {
    const SeparationStep step = ComputeSeparationStep(contact.f_Co_W, p.sigma_m2);
    const double way_m = p.eta * contact.deepest_excess_m;
    out = {way_m * step.delta_x, way_m * step.delta_phi_per_m};
  }
  const core::Pose X_WC_out = Moved(X_WC_, out);

  const Motion towards{X_WD.translation - X_WC_out.translation,
                       core::RotationVector(X_WD.rotation * glm::conjugate(X_WC_out.rotation))};

  // (2) The way to a plane is filtered by eta as the way out is, so that a step of the field does not become a step of
  // the force. A plane still deeper than p0 is left to the next (1): it only must not be entered further.
  std::array<Row, kMaxCouplingPlanes> rows;
  std::size_t num_rows = 0;
  for (const CouplingPlane& plane : contact.planes) {
    const glm::dvec3 r_cross_n = glm::cross(plane.p_CoQ_W, plane.n_W);
    const double gap_m = plane.gap_m + glm::dot(plane.n_W, out.translation_m) + glm::dot(r_cross_n, out.rotation_rad);
    Row& row = rows[num_rows++];
    row.n = plane.n_W;
    row.r_cross_n = r_cross_n;
    row.bound_m = -p.eta * std::max(gap_m + plane.rest_m, 0.0);
    row.effective_mass = 1.0 / (1.0 + glm::dot(r_cross_n, r_cross_n) / p.sigma_m2);
    row.multiplier = 0.0;
  }
  Motion allowed = ProjectOntoPlanes(towards, {rows.data(), num_rows}, p.sigma_m2);

  // Not farther than is known to be free: a point at distance r moves by at most |x| + r |phi|. A shorter way in the
  // same direction still respects every plane, because the bounds are not positive.
  const double travel_m = glm::length(allowed.translation_m) + p.bounding_radius_m * glm::length(allowed.rotation_rad);
  const double allowed_m = std::max(contact.free_distance_m, 0.0);
  const bool is_clamped = travel_m > allowed_m;
  if (is_clamped) {
    allowed.translation_m *= allowed_m / travel_m;
    allowed.rotation_rad *= allowed_m / travel_m;
  }

  bool is_held = is_clamped;
  for (std::size_t i = 0; i < num_rows; ++i) is_held = is_held || rows[i].multiplier > 0.0;
  X_WC_ = is_held ? Moved(X_WC_out, allowed) : X_WD;  // free: exactly D
  return CouplingWrench(p, X_WD, X_WC_);
}

core::Wrench CouplingWrench(const CouplingParameters& parameters, const core::Pose& X_WD, const core::Pose& X_WC) {
  const core::Pose X_DC = X_WD.inverse() * X_WC;  // Eq. 5
  return {X_WD.rotate(parameters.stiffness_N_per_m * X_DC.translation),
          X_WD.rotate(parameters.stiffness_Nm_per_rad * core::RotationVector(X_DC.rotation))};  // Eq. 6
}

}  // namespace vps
