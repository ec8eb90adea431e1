#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "space/atmosphere/air.hpp"
#include "space/atmosphere/tables.hpp"

namespace space {

// Light in the air by numeric integration in double precision, without any table.
class AirOracle {
 public:
  explicit AirOracle(const Air& air) : air_(air), shell_{air.bottom_m, air.top_m} {}

  // From r along mu over the distance d.
  [[nodiscard]] glm::dvec3 Transmittance(double r, double mu, double d, int num_steps = 400) const {
    glm::dvec3 thickness(0.0);
    for (int i = 0; i < num_steps; ++i) {  // middles
      const double there = shell_.RadiusAfter(r, mu, (i + 0.5) * d / num_steps);
      thickness += d / num_steps * ExtinctionOf(air_, DensitiesAt(air_, there - shell_.bottom));
    }
    return glm::exp(-thickness);
  }

  [[nodiscard]] glm::dvec3 ToSun(double r, double mu_s) const {
    const double sine = shell_.bottom / r, cosine = -std::sqrt(std::max(1.0 - sine * sine, 0.0));
    const double t = std::clamp(0.5 + 0.5 * (mu_s - cosine) / (sine * kSunRadius_rad), 0.0, 1.0);
    if (t == 0.0) return glm::dvec3(0.0);
    return t * t * (3.0 - 2.0 * t) * Transmittance(r, mu_s, shell_.DistanceToTop(r, mu_s));
  }

  // Light that was scattered once, with its phase functions.
  [[nodiscard]] glm::dvec3 SingleScattering(double r, double mu, double mu_s, double nu, bool meets_ground,
                                            int num_steps = 300) const {
    const double length = meets_ground ? shell_.DistanceToBottom(r, mu) : shell_.DistanceToTop(r, mu);
    const double step = length / num_steps;
    glm::dvec3 sum(0.0), thickness(0.0);
    for (int i = 0; i < num_steps; ++i) {
      const double d = (i + 0.5) * step, there = shell_.RadiusAfter(r, mu, d);
      const Densities<double> densities = DensitiesAt(air_, there - shell_.bottom);
      const glm::dvec3 extinction = ExtinctionOf(air_, densities);
      const glm::dvec3 scattered = densities.rayleigh * air_.rayleigh_per_m * RayleighPhase(nu) +
                                   densities.mie * air_.mie_per_m() * MiePhase(air_.mie_g, nu);
      const double mu_s_there = std::clamp((r * mu_s + d * nu) / there, -1.0, 1.0);
      sum += step * glm::exp(-thickness - 0.5 * step * extinction) * scattered * ToSun(there, mu_s_there);
      thickness += step * extinction;
    }
    return sum;
  }

 private:
  Air air_;
  Shell<double> shell_;
};

}  // namespace space
