#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "core/parallel_for.hpp"
#include "space/atmosphere/air.hpp"
#include "space/atmosphere/mapping.hpp"

namespace space {

// The defaults are those of [Bruneton and Neyret 2008], but for more orders of scattering.
struct AirTableSizes {
  int transmittance_mu = 256;
  int transmittance_r = 64;
  int r = 32;
  int mu = 128;  // half of them meet the ground
  int mu_s = 32;
  int nu = 8;
  int irradiance_mu_s = 64;
  int irradiance_r = 16;
  int num_orders = 6;  // how often light is scattered, at most: the sixth adds less than 0.3 %

  [[nodiscard]] std::size_t num_scattering() const {
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(mu) * static_cast<std::size_t>(mu_s) *
           static_cast<std::size_t>(nu);
  }
  bool operator==(const AirTableSizes&) const = default;
};

// What the air does to the light of a sun whose irradiance across its direction is 1.
template <typename Real>
struct AirTables {
  using Rgba = glm::vec<4, Real>;

  Air air;
  AirTableSizes sizes;
  std::vector<Rgb<Real>> transmittance;  // to the top [r][mu]
  // Scattered light, without its phase functions [r][mu][nu][mu_s]. rgb: molecules, and all that is scattered more than
  // once as if it had their phase function; a: red of what aerosols scatter once.
  std::vector<Rgba> scattering;
  std::vector<Rgb<Real>> irradiance;  // of the sky, on level ground [r][mu_s]
};

// The share done, in [0, 1], some hundred times, without workers some ten thousand times; false stops the work.
using AirProgress = std::function<bool(double)>;

// Algorithm 4.1 of [Bruneton and Neyret 2008]. None: the progress stopped it. The result does not depend on `workers`.
template <typename Real>
std::optional<AirTables<Real>> MakeAirTables(const Air& air, const AirTableSizes& sizes,
                                             core::ParallelFor* workers = nullptr, const AirProgress& progress = {});

// From the radius r along mu to the ray's end, by numeric integration and not from tables.
template <typename Real>
Rgb<Real> TransmittanceThrough(const Air& air, Real r, Real mu, bool meets_ground);

// --- Look-ups. `r` [m], cosines as in Shell.

// From the radius r along mu to the top; the ray must not meet the ground.
template <typename Real>
Rgb<Real> TransmittanceToTop(const AirTables<Real>& tables, Real r, Real mu);

// The share of the sun's light that arrives: what of its disc is above the horizon, and what the air leaves of it.
template <typename Real>
Rgb<Real> TransmittanceToSun(const AirTables<Real>& tables, Real r, Real mu_s);

// From the radius r along mu over the distance d, to the ground when it meets it there.
template <typename Real>
Rgb<Real> TransmittanceAlong(const AirTables<Real>& tables, Real r, Real mu, Real d, bool meets_ground);

// The light that the air between a point and the end of its view (the ground or the top) sends to it.
template <typename Real>
Rgb<Real> SkyRadiance(const AirTables<Real>& tables, Real r, Real mu, Real mu_s, Real nu, bool meets_ground);

// On level ground: of the sky, and of the sun.
template <typename Real>
Rgb<Real> SkyIrradiance(const AirTables<Real>& tables, Real r, Real mu_s);
template <typename Real>
Rgb<Real> GroundIrradiance(const AirTables<Real>& tables, Real mu_s);

}  // namespace space
