#include "space/atmosphere/from_space.hpp"

#include <cmath>

namespace space {
namespace {

template <typename T>
T Sample(const std::vector<T>& values, int first, int num, float x) {
  const Between<float> place = PlaceAmong(num, x);
  const T& low = values[static_cast<std::size_t>(first + place.first)];
  return low + (values[static_cast<std::size_t>(first + place.second)] - low) * place.share;
}

}  // namespace

AirFromSpace AirFromSpace::Vacuum() {
  AirFromSpace air;
  air.least_mu_s = 0.0f;
  air.through.assign(std::size_t{2} * kThroughRows, glm::vec3(1.0f));
  for (int i = 0; i < kGroundSamples; ++i) {
    air.ground_light.emplace_back(static_cast<float>(i) / static_cast<float>(kGroundSamples - 1));
  }
  return air;
}

AirFromSpace AirFromSpace::From(const AirTables<float>& tables) {
  AirFromSpace air;
  const AirTableSizes& n = tables.sizes;
  air.mapping = AirMapping<float>(tables.air);
  air.mie_g = static_cast<float>(tables.air.mie_g);
  air.least_mu_s = static_cast<float>(tables.air.least_mu_s);
  air.mie_ratio = MieRatio<float>(tables.air);
  air.num_mu = n.mu;
  air.num_nu = n.nu;
  air.num_mu_s = n.mu_s;
  const auto layer = static_cast<std::ptrdiff_t>(tables.scattering.size()) / n.r;
  air.scattering.assign(tables.scattering.end() - layer, tables.scattering.end());
  const float top = air.mapping.shell().top;
  for (int half = 0; half < 2; ++half) {
    for (int i = 0; i < kThroughRows; ++i) {
      const float x = static_cast<float>(i) / static_cast<float>(kThroughRows - 1);
      const bool meets_ground = half == 0;
      const float mu = meets_ground ? air.mapping.ToDownward(top, x) : air.mapping.ToUpward(top, x);
      air.through.push_back(TransmittanceThrough(tables.air, top, mu, meets_ground));
    }
  }
  for (int i = 0; i < kGroundSamples; ++i) {
    const float x = static_cast<float>(i) / static_cast<float>(kGroundSamples - 1);
    air.ground_light.push_back(GroundIrradiance(tables, air.least_mu_s + x * (1.0f - air.least_mu_s)));
  }
  return air;
}

glm::vec3 Through(const AirFromSpace& air, double miss_m) {
  const double top = air.mapping.shell().top, bottom = air.mapping.shell().bottom;
  const double half = std::sqrt(std::max((top - miss_m) * (top + miss_m), 0.0));
  const double horizon = std::sqrt((top - bottom) * (top + bottom));
  if (miss_m >= bottom) {
    return Sample(air.through, AirFromSpace::kThroughRows, AirFromSpace::kThroughRows,
                  static_cast<float>(half / horizon));
  }
  const double least = top - bottom;
  const double x = (half - std::sqrt((bottom - miss_m) * (bottom + miss_m)) - least) / (horizon - least);
  return Sample(air.through, 0, AirFromSpace::kThroughRows, static_cast<float>(x));
}

// The sun's disc in strips along the horizon, which is straight at its size; a strip at the height s of the unit disc
// is 2 sqrt(1 - s^2) wide.
glm::dvec3 SunLight(const Surroundings& space, const AirFromSpace& air) {
  constexpr int kStrips = 64;
  const double distance_m = glm::length(space.X_WE.translation);
  const double bottom = air.mapping.shell().bottom, top = air.mapping.shell().top;
  const double cosine = glm::dot(space.sun_direction_W, space.X_WE.translation) / distance_m;
  const double angle = std::acos(std::clamp(cosine, -1.0, 1.0));
  glm::dvec3 sum(0.0);
  double all = 0.0;
  for (int i = 0; i < kStrips; ++i) {
    const double s = (2.0 * i + 1.0) / kStrips - 1.0, width = std::sqrt(1.0 - s * s);
    const double there = angle + s * kSunRadius_rad;
    const bool is_ahead = 2.0 * there < std::acos(-1.0);
    const double miss_m = is_ahead ? distance_m * std::sin(there) : 2.0 * top;
    all += width;
    if (miss_m >= top) {
      sum += width;
    } else if (miss_m >= bottom) {
      sum += width * glm::dvec3(Through(air, miss_m));
    }
  }
  return sum / all;
}

}  // namespace space
