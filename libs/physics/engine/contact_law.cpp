#include "physics/engine/contact_law.hpp"

#include <algorithm>

namespace physics {
namespace {

// Range of s = k dt^2 / m over which the force changes from energy-keeping to implicit. At 0.5 a contact lasts
// pi / sqrt(s) = 4.4 steps, too few to resolve it. The upper end is chosen; restitution over s is charted by
// `oos bench physics --pair rebound` (docs/performance/physics.md): 0.89 at 0.67, 0.67 at 1, 0.27 at 2.
constexpr double kFirstImplicit = 0.5;
constexpr double kAllImplicit = 2.0;
// Recovery from overlap of hard contacts: a share of it in a step, at most at this speed. A free choice: faster
// recovery leaves more motion behind, slower leaves bodies inside each other for longer. At 0.2 m/s springs that grow
// stiffer or whose planes are late give energy (Contact.PassiveSprings*, Rebound.OfPassiveContacts*), at 2 mm/s a load
// is not held.
constexpr double kPartingShare = 0.2;
constexpr double kPartingSpeed_m_per_s = 0.02;

// Compliance of hard contacts relative to the row's inverse mass. Between bodies a free choice: the error is one part
// in 10^6, and larger ones press less. Jaws that close on a body contradict each other: the force is what would stop
// the body in a step, divided by the compliance, friction across it is as large, and what the solver leaves of both
// throws the body. With 1e-6 a part is shot out (HeldParts.HardJawsDoNotShootOutWhatTheySqueeze), of 240 sizes, masses,
// tilts and speeds at 1e-4 and 1e-3 none is lost but some reach 2 m/s, at 1e-2 0.5 m/s, as between springs, at 1 0.3
// m/s. A hand that presses with 20 N on 50 g comes 20 um too deep with it.
constexpr double kHardSoftness = 1e-6;
constexpr double kHandSoftness = 1e-2;

// Compliance of the stop at that speed relative to the inverse effective mass: of the speed that the spring would have
// made in a step, a ten-thousandth is left. With a hundredth Contact.PassiveSpringsThatNoWork* fails; smaller makes
// worse conditioned rows, and a millionth passes too.
constexpr double kStopSoftness = 1e-4;

// F = -(V(b) - V(a)) / (b - a) for V(g) = k min(g, 0)^2 / 2, and its slope -dF/db. F is convex in b, and its derivative
// is continuous where b changes sign.
ForceLine DiscreteGradient(double k, double a, double b) {
  if (a >= 0.0) {
    if (b >= 0.0) return {};
    const double length = a - b;
    return {0.5 * k * b * b / length, -0.5 * k * b * (length + a) / (length * length)};
  }
  if (b <= 0.0) return {-0.5 * k * (a + b), 0.5 * k};
  const double length = b - a;
  return {0.5 * k * a * a / length, 0.5 * k * a * a / (length * length)};
}

// The rest of the force, that no work has paid for, is stopped at the parting speed.
void StopUnpaid(double paid_share, double inverse_mass_per_kg, double v1, double dt_s, UnpaidPiece* piece,
                ForceLine* line) {
  const double stop_N_s_per_m = 1.0 / (kStopSoftness * inverse_mass_per_kg * dt_s);
  const double stop_N = stop_N_s_per_m * (v1 - kPartingSpeed_m_per_s);
  const double unpaid_N = (1.0 - paid_share) * line->force_N;
  UnpaidPiece at = stop_N <= 0.0        ? UnpaidPiece::kPushes
                   : stop_N <= unpaid_N ? UnpaidPiece::kIsStopped
                                        : UnpaidPiece::kIsLeftOut;
  if (piece != nullptr) {
    if (*piece != at && *piece != UnpaidPiece::kIsStopped) at = UnpaidPiece::kIsStopped;
    *piece = at;
  }
  if (at == UnpaidPiece::kIsLeftOut) {
    line->force_N *= paid_share;
    line->slope_N_s_per_m *= paid_share;
  } else if (at == UnpaidPiece::kIsStopped) {
    line->force_N -= stop_N;
    line->slope_N_s_per_m += stop_N_s_per_m;
  }
}

}  // namespace

double SpringEnergy_J(double stiffness_N_per_m, double gap_m) {
  const double depth_m = std::min(gap_m, 0.0);
  return 0.5 * stiffness_N_per_m * depth_m * depth_m;
}

double ImplicitShare(double pair_stiffness_N_per_m, double inverse_mass_per_kg, double dt_s) {
  const double s = pair_stiffness_N_per_m * dt_s * dt_s * inverse_mass_per_kg;
  return std::clamp((s - kFirstImplicit) / (kAllImplicit - kFirstImplicit), 0.0, 1.0);
}

ForceLine CompliantForce(const ContactLaw& law, double inverse_mass_per_kg, double v0, double v1, double dt_s,
                         UnpaidPiece* piece) {
  const double k = law.stiffness_N_per_m;
  const double share = ImplicitShare(law.pair_stiffness_N_per_m, inverse_mass_per_kg, dt_s);
  // Not cut off where it would pull: for a linear law one Newton step suffices, and the row's limit excludes tension.
  ForceLine line{-k * (law.gap_m + dt_s * v1), k * dt_s};
  if (share < 1.0) {
    const ForceLine exact =
        DiscreteGradient(k, law.gap_m - 0.5 * dt_s * v0, law.gap_m + 0.5 * dt_s * v1);  // db/dv1 = dt / 2
    if (line.force_N < 0.0) line = {};
    line.force_N = share * line.force_N + (1.0 - share) * exact.force_N;
    line.slope_N_s_per_m = share * line.slope_N_s_per_m + (1.0 - share) * 0.5 * dt_s * exact.slope_N_s_per_m;
  }
  if (law.paid_share < 1.0) StopUnpaid(law.paid_share, inverse_mass_per_kg, v1, dt_s, piece, &line);
  line.force_N -= law.damping_N_s_per_m * v1;
  line.slope_N_s_per_m += law.damping_N_s_per_m;
  return line;
}

double HardSoftness(bool is_of_hand) {
  return is_of_hand ? kHandSoftness : kHardSoftness;
}

double HardSpeed_m_per_s(double gap_m, double dt_s) {
  return gap_m > 0.0 ? -gap_m / dt_s : std::min(-kPartingShare * gap_m / dt_s, kPartingSpeed_m_per_s);
}

}  // namespace physics
