#pragma once

#include <optional>

namespace stability {

// One axis of a hand device, read and driven once per period: a mass with viscous damping, on which a wall
//   F_k = -K x_k - B (x_k - x_{k-1}) / T
// is rendered. F_k acts from k T + t_d on and is held for one period T. A rotation has the same form, with kg m^2,
// Nm s/rad and Nm/rad.
//
// Normalised: alpha = K T^2 / m, beta = B T / m, delta = b T / m, d = t_d / T.
struct SampledAxis {
  double mass_kg = 1.0;
  double damping_N_s_per_m = 0.0;  // of the device itself, b
  double period_s = 1e-3;          // T
  double delay_s = 0.0;            // t_d, any fraction of a period; the hold's T / 2 does not belong to it
};

// Stiffness K and damping B that are rendered.
struct Wall {
  double stiffness_N_per_m = 0.0;
  double damping_N_s_per_m = 0.0;
};

// Delays beyond this are computed as this one: at 1 kHz twice the 60 ms after which no force is left.
constexpr int kMaxDelay_periods = 128;

// All functions here: real-time, no allocation. A wall at the boundary costs up to 60 tests of a polynomial of degree
// t_d / T + 4.

// Whether every motion on the wall decays. Exact: the roots of the loop's characteristic polynomial lie inside the unit
// circle. With t_d = (n + f) T, 0 <= f < 1, the force of two samples acts in each period, and
//   z^(n+2) (z - 1) (z - E) + N(z) ((alpha + beta) z - beta) = 0,   E = exp(-delta).
bool IsStable(const SampledAxis& axis, const Wall& wall) noexcept;

// Largest stable K for a given B; 0 when no K > 0 is stable.
double MaxStiffness(const SampledAxis& axis, double damping_N_s_per_m) noexcept;

// The wall with the largest stable K of all.
Wall StiffestWall(const SampledAxis& axis) noexcept;

// Smallest and largest stable B for a given K; none above the stiffest wall. `least` is 0 when the device's own damping
// suffices.
struct DampingRange {
  double least_N_s_per_m = 0.0;
  double most_N_s_per_m = 0.0;
};
std::optional<DampingRange> StableDamping(const SampledAxis& axis, double stiffness_N_per_m) noexcept;

// Largest B that is stable with the wall's K, searched upwards from the wall's B; 0 when the wall itself is unstable.
// Much cheaper than StableDamping.
double MaxDamping(const SampledAxis& axis, const Wall& wall) noexcept;

// K < (b + B) / (T / 2 + t_d) [Gil, Sanchez, Hulin, Preusche, Hirzinger 2009]: the tangent of the exact boundary at
// K = 0. For display. It is up to 30 % too high where B is a fifth of the largest stable one, so no code relies on it.
double LinearStiffnessRule(const SampledAxis& axis, double damping_N_s_per_m) noexcept;

// K and B that dissipate an impact fastest without oscillation [Hulin et al. 2013]: the three slowest poles coincide.
// With t_0 = t_d + T and b = 0 about K = 0.079 m / t_0^2 and B = 0.46 m / t_0; settled to 1 % after 16 t_0.
Wall FastestDecay(const SampledAxis& axis) noexcept;

}  // namespace stability
