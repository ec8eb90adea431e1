#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "space/orbit.hpp"

namespace space {

constexpr double kSunRadius_rad = 0.00465;  // of its disc

// Light of 680, 550 and 440 nm, which is drawn as red, green and blue.
template <typename Real>
using Rgb = glm::vec<3, Real>;

// What the Earth's air is made of. Figures of the "new implementation" of [Bruneton 2017]: molecules (Rayleigh) and
// aerosols (Mie) that thin out exponentially with the height, and ozone, which absorbs, in a layer around 25 km.
struct Air {
  double bottom_m = kEarthMeanRadius_m;
  double top_m = kEarthMeanRadius_m + 60e3;
  double rayleigh_height_m = 8000.0;
  glm::dvec3 rayleigh_per_m{5.802e-6, 13.558e-6, 33.1e-6};
  double mie_height_m = 1200.0;
  double mie_extinction_per_m = 4.44e-6;
  double mie_albedo = 0.9;  // of a meeting with an aerosol, what is scattered
  double mie_g = 0.8;       // mean cosine of the angle by which an aerosol deflects
  double ozone_middle_m = 25e3;
  double ozone_half_width_m = 15e3;
  glm::dvec3 ozone_per_m{0.650e-6, 1.881e-6, 0.085e-6};
  double ground_albedo = 0.1;
  double least_mu_s = -0.20791169;  // a sun that is 102 degrees from the zenith is the lowest that lights any air

  [[nodiscard]] glm::dvec3 mie_per_m() const { return glm::dvec3(mie_albedo * mie_extinction_per_m); }
};

// Densities at a height, relative to each one's largest.
template <typename Real>
struct Densities {
  Real rayleigh = 0;
  Real mie = 0;
  Real ozone = 0;
};

template <typename Real>
Densities<Real> DensitiesAt(const Air& air, Real height_m) {
  const Real h = std::max(height_m, Real(0));
  const Real off = std::abs(h - Real(air.ozone_middle_m)) / Real(air.ozone_half_width_m);
  return {std::exp(-h / Real(air.rayleigh_height_m)), std::exp(-h / Real(air.mie_height_m)),
          std::max(Real(0), Real(1) - off)};
}

// Extinction [1/m].
template <typename Real>
Rgb<Real> ExtinctionOf(const Air& air, const Densities<Real>& densities) {
  return densities.rayleigh * Rgb<Real>(air.rayleigh_per_m) + densities.mie * Real(air.mie_extinction_per_m) +
         densities.ozone * Rgb<Real>(air.ozone_per_m);
}

// Green and blue of what aerosols scatter, against its red, where molecules scatter all three alike.
template <typename Real>
Rgb<Real> MieRatio(const Air& air) {
  const glm::dvec3 mie = air.mie_per_m();
  if (mie.x <= 0.0) return Rgb<Real>(0);
  return Rgb<Real>(mie / air.rayleigh_per_m * (air.rayleigh_per_m.x / mie.x));
}

// Phase functions of the cosine of the angle between light and view [1/sr]: which share of the scattered light takes
// that direction. P_R = 3 / (16 pi) (1 + nu^2), and that of Cornette and Shanks [1992],
// P_M = 3 / (8 pi) (1 - g^2) (1 + nu^2) / ((2 + g^2) (1 + g^2 - 2 g nu)^(3/2)).
template <typename Real>
Real RayleighPhase(Real nu) {
  return Real(3.0 / (16.0 * 3.14159265358979323846)) * (Real(1) + nu * nu);
}

template <typename Real>
Real MiePhase(Real g, Real nu) {
  const Real k = Real(3.0 / (8.0 * 3.14159265358979323846)) * (Real(1) - g * g) / (Real(2) + g * g);
  const Real q = Real(1) + g * g - Real(2) * g * nu;
  return k * (Real(1) + nu * nu) / (q * std::sqrt(q));
}

}  // namespace space
