#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <utility>

#include "core/read_file.hpp"
#include "core/write_file.hpp"
#include "space/atmosphere/from_space.hpp"
#include "space/atmosphere/table_file.hpp"
#include "space/atmosphere/tables.hpp"
#include "space/testing/air_oracle.hpp"

namespace space {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kEpsilon = 1e-3;

// Seconds instead of half a minute.
AirTableSizes SmallSizes() {
  AirTableSizes sizes;
  sizes.r = 12;
  sizes.mu = 48;
  sizes.mu_s = 20;
  sizes.num_orders = 3;
  return sizes;
}

template <typename Real>
const AirTables<Real>& SmallTables() {
  static const AirTables<Real> kTables = *MakeAirTables<Real>(Air{}, SmallSizes());
  return kTables;
}

double Uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1.0p-53;
}

double RelativeError(const glm::dvec3& got, const glm::dvec3& expected) {
  const glm::dvec3 error = glm::abs(got / expected - 1.0);
  return std::sqrt(glm::dot(error, error));  // of all colours, and no number if one is none
}

// --- Geometry

TEST(AirShell, DistancesAreThoseOfStraightRaysThroughSpheres) {
  const Shell<double> shell{6371e3, 6431e3};
  const double r = 0.5 * (shell.bottom + shell.top);
  EXPECT_NEAR(shell.DistanceToTop(r, 1.0), shell.top - r, 1e-6);
  EXPECT_NEAR(shell.DistanceToTop(r, 0.0), std::sqrt(shell.top * shell.top - r * r), 1e-3);
  EXPECT_NEAR(shell.DistanceToTop(shell.top, -1.0), 2.0 * shell.top, 1e-6);
  EXPECT_NEAR(shell.DistanceToBottom(r, -1.0), r - shell.bottom, 1e-6);
  const double horizon = -std::sqrt(1.0 - shell.bottom * shell.bottom / (r * r));
  EXPECT_NEAR(shell.DistanceToBottom(r, horizon - 1e-12), shell.to_horizon(r), 10.0);
  EXPECT_TRUE(shell.MeetsGround(r, horizon - 1e-9));
  EXPECT_FALSE(shell.MeetsGround(r, horizon + 1e-9));
  EXPECT_TRUE(shell.MeetsGround(r, -1.0));
  EXPECT_FALSE(shell.MeetsGround(r, 1.0));
}

TEST(AirShell, FloatsSuffice) {
  const Shell<double> exact{6371e3, 6431e3};
  const Shell<float> shell{6371e3f, 6431e3f};
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    const auto r = static_cast<float>(exact.bottom + 10.0 + Uniform(random) * 59980.0);
    const auto mu = static_cast<float>(2.0 * Uniform(random) - 1.0);
    const double to_top = exact.DistanceToTop(r, mu);
    EXPECT_NEAR(shell.DistanceToTop(r, mu) / to_top, 1.0, 1e-4);
  }
}

TEST(AirMapping, EveryTableFindsItsOwnSamples) {
  const AirMapping<double> mapping{Air{}};
  for (int i = 0; i <= 40; ++i) {
    const double x = i / 40.0, r = mapping.ToRadius(x);
    EXPECT_NEAR(mapping.FromRadius(r), x, kEpsilon);
    EXPECT_NEAR(mapping.FromSun(mapping.ToSun(x)), x, kEpsilon);
    for (int k = 0; k <= 40; ++k) {
      const double y = k / 40.0;
      EXPECT_NEAR(mapping.FromUpward(r, mapping.ToUpward(r, y)), y, kEpsilon) << r << " " << y;
      if (i > 0) {
        EXPECT_NEAR(mapping.FromDownward(r, mapping.ToDownward(r, y)), y, kEpsilon) << r << " " << y;
      }
    }
  }
  EXPECT_NEAR(mapping.ToUpward(mapping.shell().bottom, 1.0), 0.0, kEpsilon);
  EXPECT_NEAR(mapping.ToSun(0.0), Air{}.least_mu_s, kEpsilon);
}

TEST(AirMapping, TheLimitsOfWhatItDependsOnAreTheFirstSampleAndTheLast) {
  const AirMapping<double> mapping{Air{}};
  const Shell<double>& shell = mapping.shell();
  EXPECT_NEAR(mapping.FromRadius(shell.bottom), 0.0, kEpsilon);
  EXPECT_NEAR(mapping.FromRadius(shell.top), 1.0, kEpsilon);
  for (const double r : {shell.bottom, 0.5 * (shell.bottom + shell.top), shell.top}) {
    const double horizon = -std::sqrt(1.0 - shell.bottom * shell.bottom / (r * r));
    EXPECT_NEAR(mapping.FromUpward(r, 1.0), 0.0, kEpsilon);
    EXPECT_NEAR(mapping.FromUpward(r, horizon), 1.0, kEpsilon);
    EXPECT_NEAR(mapping.FromDownward(r, -1.0), 0.0, kEpsilon);
    if (r > shell.bottom) {
      EXPECT_NEAR(mapping.FromDownward(r, horizon - 1e-12), 1.0, kEpsilon);
    }
  }
  EXPECT_NEAR(mapping.FromSun(1.0), 1.0, kEpsilon);
  EXPECT_NEAR(mapping.FromSun(Air{}.least_mu_s), 0.0, kEpsilon);
  EXPECT_NEAR(mapping.FromSun(-1.0), 0.0, kEpsilon) << "lower than the lowest sun that lights any air";
}

TEST(AirMapping, ATablesFirstSampleIsAtZeroAndItsLastAtOne) {
  const auto expect = [](double x, int first, double share) {
    const Between<double> place = PlaceAmong(10, x);
    EXPECT_NEAR(place.first + place.share, first + share, 1e-12) << x;
    EXPECT_LE(place.second, 9);
  };
  expect(0.0, 0, 0.0);
  expect(1.0, 9, 0.0);
  expect(1.0 / 3.0, 3, 0.0);
  expect(0.25, 2, 0.25);
  expect(-0.2, 0, 0.0);
  expect(1.2, 9, 0.0);
}

// --- Composition

TEST(Air, DensitiesFallByETimesPerScaleHeightAndOzoneIsALayer) {
  const Air air;
  EXPECT_NEAR(DensitiesAt(air, 8000.0).rayleigh, std::exp(-1.0), 1e-12);
  EXPECT_NEAR(DensitiesAt(air, 2400.0).mie, std::exp(-2.0), 1e-12);
  EXPECT_EQ(DensitiesAt(air, 25e3).ozone, 1.0);
  EXPECT_NEAR(DensitiesAt(air, 32.5e3).ozone, 0.5, 1e-12);
  EXPECT_EQ(DensitiesAt(air, 5e3).ozone, 0.0);
}

TEST(Air, PhaseFunctionsShareOutAllLight) {
  constexpr int kNum = 100000;
  double rayleigh = 0.0, mie = 0.0, mean = 0.0;
  for (int i = 0; i < kNum; ++i) {
    const double nu = (2.0 * i + 1.0) / kNum - 1.0;
    rayleigh += 4.0 * kPi / kNum * RayleighPhase(nu);
    mie += 4.0 * kPi / kNum * MiePhase(0.8, nu);
    mean += 4.0 * kPi / kNum * RayleighPhase(nu) * nu;
  }
  EXPECT_NEAR(rayleigh, 1.0, kEpsilon);
  EXPECT_NEAR(mie, 1.0, kEpsilon);
  EXPECT_NEAR(mean, 0.0, kEpsilon);
}

// --- Transmittance

TEST(Transmittance, UniformAirFollowsBeersLaw) {
  Air air;
  air.rayleigh_height_m = 1e15;
  air.mie_extinction_per_m = 0.0;
  air.ozone_per_m = glm::dvec3(0.0);
  const double r = air.bottom_m + 20e3;
  for (const double mu : {1.0, 0.3, 0.0}) {
    const double d = Shell<double>{air.bottom_m, air.top_m}.DistanceToTop(r, mu);
    EXPECT_LT(RelativeError(TransmittanceThrough(air, r, mu, false), glm::exp(-d * air.rayleigh_per_m)), 1e-9);
  }
}

Air WithoutOzone() {
  Air air;
  air.ozone_per_m = glm::dvec3(0.0);
  return air;
}

// Between two heights, of a density exp(-h / K): K (exp(-low / K) - exp(-high / K)).
double OpticalLength_m(double height_m, double low_m, double high_m) {
  return height_m * (std::exp(-low_m / height_m) - std::exp(-high_m / height_m));
}

// Straight up or down between two heights.
glm::dvec3 StraightThrough(const Air& air, double low_m, double high_m) {
  return glm::exp(-air.rayleigh_per_m * OpticalLength_m(air.rayleigh_height_m, low_m, high_m) -
                  air.mie_extinction_per_m * OpticalLength_m(air.mie_height_m, low_m, high_m));
}

TEST(Transmittance, StraightUpItIsThatOfTheExponentialsIntegral) {
  const Air air = WithoutOzone();
  for (const double h : {0.0, 2e3, 48e3}) {
    const glm::dvec3 got = TransmittanceThrough(air, air.bottom_m + h, 1.0, false);
    EXPECT_LT(RelativeError(got, StraightThrough(air, h, air.top_m - air.bottom_m)), kEpsilon) << h;
  }
}

// Of air thin enough that something comes through the longest way, as a part's is a quotient of two whole ones.
TEST(Transmittance, AlongAPartOfARayUniformAirFollowsBeersLawUpwardsAndDownwards) {
  Air air = WithoutOzone();
  air.rayleigh_height_m = 1e15;
  air.rayleigh_per_m = {0.3e-6, 0.6e-6, 1e-6};
  air.mie_extinction_per_m = 0.0;
  AirTableSizes sizes = SmallSizes();
  sizes.num_orders = 1;
  const AirTables<double> tables = *MakeAirTables<double>(air, sizes);
  const Shell<double> shell{air.bottom_m, air.top_m};
  const double d = 6e3, r = shell.bottom + 48e3;
  const glm::dvec3 expected = glm::exp(-d * air.rayleigh_per_m);
  for (const auto& [from, mu] : {std::pair{shell.bottom, 0.0}, {r, 0.7}, {r, -0.7}}) {
    const glm::dvec3 got = TransmittanceAlong(tables, from, mu, d, shell.MeetsGround(from, mu));
    EXPECT_LT(glm::length(got - expected), kEpsilon) << mu;
  }
}

TEST(Transmittance, TheTableIsTheNumericIntegral) {
  const AirOracle oracle{Air{}};
  const AirTables<double>& tables = SmallTables<double>();
  const AirMapping<double> mapping{Air{}};
  std::mt19937_64 random(2);
  for (int i = 0; i < 100; ++i) {
    const double r = mapping.ToRadius(std::floor(64.0 * Uniform(random)) / 63.0);
    const double mu = mapping.ToUpward(r, std::floor(256.0 * Uniform(random)) / 255.0);
    const glm::dvec3 expected = oracle.Transmittance(r, mu, mapping.shell().DistanceToTop(r, mu), 1000);
    EXPECT_LT(glm::length(TransmittanceToTop(tables, r, mu) - expected), kEpsilon) << r << " " << mu;
  }
}

// Near the horizon it changes much from one sample to the next.
TEST(Transmittance, BetweenItsSamplesTheTableIsRightWithinAFewThousandths) {
  const AirOracle oracle{Air{}};
  const AirTables<double>& tables = SmallTables<double>();
  const AirMapping<double> mapping{Air{}};
  std::mt19937_64 random(3);
  for (int i = 0; i < 100; ++i) {
    const double r = mapping.ToRadius(Uniform(random)), mu = mapping.ToUpward(r, Uniform(random));
    const double length = mapping.shell().DistanceToTop(r, mu), part = Uniform(random) * length;
    EXPECT_LT(glm::length(TransmittanceToTop(tables, r, mu) - oracle.Transmittance(r, mu, length, 1000)), 0.005);
    EXPECT_LT(glm::length(TransmittanceAlong(tables, r, mu, part, false) - oracle.Transmittance(r, mu, part, 1000)),
              0.015);
  }
}

TEST(Transmittance, DownToTheGroundItIsThatOfTheWayBack) {
  const AirOracle oracle{Air{}};
  const Shell<double> shell = AirMapping<double>{Air{}}.shell();
  for (const double mu : {-1.0, -0.6, -0.3, -0.2}) {
    const double r = shell.bottom + 50e3, d = shell.DistanceToBottom(r, mu);
    EXPECT_LT(glm::length(TransmittanceAlong(SmallTables<double>(), r, mu, d, true) - oracle.Transmittance(r, mu, d)),
              kEpsilon);
  }
}

// --- Scattering

TEST(Scattering, OnceScatteredLightIsTheNumericIntegral) {
  const AirOracle oracle{Air{}};
  AirTableSizes sizes = SmallSizes();
  sizes.num_orders = 1;
  const AirTables<double> tables = *MakeAirTables<double>(Air{}, sizes);
  const AirMapping<double> mapping{Air{}};
  // Light is scattered into the view at the table's own samples, so that this compares no interpolation.
  for (const int i : {0, 5, 11}) {
    const double r = mapping.ToRadius(i / 11.0);
    for (const double y : {0.0, 7.0 / 23.0, 1.0}) {
      for (const double z : {9.0 / 19.0, 15.0 / 19.0, 1.0}) {
        for (const bool meets_ground : {false, true}) {
          if (meets_ground && i == 0) continue;
          const double mu = meets_ground ? mapping.ToDownward(r, y) : mapping.ToUpward(r, y), mu_s = mapping.ToSun(z);
          const double reach = std::sqrt((1.0 - mu * mu) * (1.0 - mu_s * mu_s));
          for (const double nu : {1.0 / 7.0, 3.0 / 7.0, 1.0}) {
            if (std::abs(nu - mu * mu_s) > reach) continue;
            const glm::dvec3 got = SkyRadiance(tables, r, mu, mu_s, nu, meets_ground);
            const glm::dvec3 expected = oracle.SingleScattering(r, mu, mu_s, nu, meets_ground);
            // Green and blue of aerosols are derived from red, which loses a little in the densest air.
            EXPECT_LT(glm::length(got - expected), kEpsilon + 0.03 * glm::length(expected))
                << i << " " << mu << " " << mu_s << " " << nu << " " << meets_ground;
          }
        }
      }
    }
  }
}

// With the sun at the zenith and a view straight up, light takes the whole way through the air wherever it is
// scattered: b K (1 - exp(-H / K)) exp(-tau). Straight down and without aerosols it goes through what is above that
// place twice: (1 - exp(-2 b K (1 - exp(-H / K)))) / 2, for a scattering coefficient b, a scale height K, air as high
// as H, and the optical depth tau of all of it.
TEST(Scattering, StraightUpAndDownOnceScatteredLightHasItsClosedForm) {
  AirTableSizes sizes = SmallSizes();
  sizes.num_orders = 1;
  Air air = WithoutOzone();
  const double high_m = air.top_m - air.bottom_m;
  const glm::dvec3 molecules = air.rayleigh_per_m * OpticalLength_m(air.rayleigh_height_m, 0.0, high_m);
  const glm::dvec3 aerosols = air.mie_per_m() * OpticalLength_m(air.mie_height_m, 0.0, high_m);
  const glm::dvec3 up = SkyRadiance(*MakeAirTables<double>(air, sizes), air.bottom_m, 1.0, 1.0, 1.0, false);
  const glm::dvec3 expected_up =
      StraightThrough(air, 0.0, high_m) * (molecules * RayleighPhase(1.0) + aerosols * MiePhase(air.mie_g, 1.0));
  EXPECT_LT(RelativeError(up, expected_up), 10.0 * kEpsilon);

  air.mie_extinction_per_m = 0.0;
  const glm::dvec3 down = SkyRadiance(*MakeAirTables<double>(air, sizes), air.top_m, -1.0, 1.0, -1.0, true);
  const glm::dvec3 expected_down = 0.5 * (1.0 - glm::exp(-2.0 * molecules)) * RayleighPhase(-1.0);
  EXPECT_LT(RelativeError(down, expected_down), 10.0 * kEpsilon);
}

// The second order by brute force: at each step of the ray, what arrives from all sides of light that was scattered
// once, or that the ground reflects.
TEST(Scattering, TwiceScatteredLightIsTheNumericIntegral) {
  Air air;
  air.mie_extinction_per_m = 0.0;  // a sharp phase function would need many directions
  const AirOracle oracle{air};
  AirTableSizes sizes = SmallSizes();
  sizes.num_orders = 1;
  const AirTables<double> once = *MakeAirTables<double>(air, sizes);
  sizes.num_orders = 2;
  const AirTables<double> twice = *MakeAirTables<double>(air, sizes);
  const Shell<double> shell{air.bottom_m, air.top_m};
  const double r = shell.bottom + 1000.0, mu = 0.5, mu_s = 0.6;
  const glm::dvec3 sun(0.8, 0.0, 0.6), view(std::sqrt(0.75), 0.0, mu);
  const double nu = glm::dot(sun, view), length = shell.DistanceToTop(r, mu);
  constexpr int kSteps = 20, kDirections = 200;
  glm::dvec3 expected(0.0);
  for (int i = 0; i < kSteps; ++i) {
    const double d = (i + 0.5) * length / kSteps;
    const glm::dvec3 place = glm::dvec3(0.0, 0.0, r) + d * view, zenith = glm::normalize(place);
    const double there = glm::length(place);
    glm::dvec3 source(0.0);
    for (int k = 0; k < kDirections; ++k) {
      const double z = 1.0 - (2.0 * k + 1.0) / kDirections, ring = std::sqrt(1.0 - z * z), turn = 2.399963229728653 * k;
      const glm::dvec3 from(ring * std::cos(turn), ring * std::sin(turn), z);
      const double mu_from = glm::dot(from, zenith);
      const bool meets_ground = shell.MeetsGround(there, mu_from);
      glm::dvec3 light =
          oracle.SingleScattering(there, mu_from, glm::dot(sun, zenith), glm::dot(sun, from), meets_ground, 20);
      if (meets_ground) {
        const double to_ground = shell.DistanceToBottom(there, mu_from);
        const double mu_s_there = glm::dot(glm::normalize(place + to_ground * from), sun);
        light += oracle.Transmittance(there, mu_from, to_ground, 50) * air.ground_albedo / kPi *
                 std::max(mu_s_there, 0.0) * oracle.ToSun(shell.bottom, mu_s_there);
      }
      source += 4.0 * kPi / kDirections * RayleighPhase(glm::dot(view, from)) * light;
    }
    const double density = DensitiesAt(air, there - shell.bottom).rayleigh;
    expected += length / kSteps * oracle.Transmittance(r, mu, d, 100) * density * air.rayleigh_per_m * source;
  }
  const glm::dvec3 got = SkyRadiance(twice, r, mu, mu_s, nu, false) - SkyRadiance(once, r, mu, mu_s, nu, false);
  EXPECT_LT(RelativeError(got, expected), 0.03) << got.x << " " << got.z << ", not " << expected.x << " " << expected.z;
}

// Neither air nor ground absorbs: all that comes to the Earth leaves it, after many orders.
TEST(Scattering, ALosslessEarthSendsBackAllLight) {
  Air air;
  air.ozone_per_m = glm::dvec3(0.0);
  air.mie_albedo = 1.0;
  air.ground_albedo = 1.0;
  air.rayleigh_per_m = {5e-6, 15e-6, 30e-6};
  AirTableSizes sizes = SmallSizes();
  sizes.num_orders = 12;
  const AirTables<double> tables = *MakeAirTables<double>(air, sizes);
  const Shell<double> shell{air.bottom_m, air.top_m};
  glm::dvec3 out(0.0);
  constexpr int kSuns = 60, kHeights = 80, kTurns = 16;
  for (int i = 0; i < kSuns; ++i) {
    const double mu_s = 2.0 * (i + 0.5) / kSuns - 1.0, sun_x = std::sqrt(1.0 - mu_s * mu_s);
    for (int k = 0; k < kHeights; ++k) {
      const double mu = -(k + 0.5) / kHeights, ring = std::sqrt(1.0 - mu * mu);
      const bool meets_ground = shell.MeetsGround(shell.top, mu);
      for (int n = 0; n < kTurns; ++n) {
        const double nu = ring * std::cos((n + 0.5) * kPi / kTurns) * sun_x + mu * mu_s;
        glm::dvec3 light = SkyRadiance(tables, shell.top, mu, mu_s, nu, meets_ground);
        if (meets_ground) {
          const double d = shell.DistanceToBottom(shell.top, mu);
          light += TransmittanceAlong(tables, shell.top, mu, d, true) / kPi *
                   GroundIrradiance(tables, (shell.top * mu_s + d * nu) / shell.bottom);
        }
        // The area of a ring of the sphere, the solid angle, and the cosine.
        out += 4.0 * kPi / kSuns * (2.0 * kPi / kHeights / kTurns) * -mu * light;
      }
    }
  }
  // What only passes through the air at the limb.
  constexpr int kRings = 400;
  for (int i = 0; i < kRings; ++i) {
    const double miss = shell.bottom + (i + 0.5) * (shell.top - shell.bottom) / kRings;
    const double mu = -std::sqrt(1.0 - miss * miss / (shell.top * shell.top));
    out += 2.0 * kPi * miss * (shell.top - shell.bottom) / kRings / (shell.top * shell.top) *
           TransmittanceThrough(air, shell.top, mu, false);
  }
  EXPECT_LT(RelativeError(out, glm::dvec3(kPi)), 0.03) << out.x / kPi << " " << out.y / kPi << " " << out.z / kPi;
}

// --- Irradiance

TEST(Irradiance, TheGroundsIsThatOfTheSunAndOfAllTheSky) {
  AirTableSizes sizes = SmallSizes();
  sizes.num_orders = 2;
  const AirTables<double> fewer = *MakeAirTables<double>(Air{}, sizes);
  const AirTables<double>& tables = SmallTables<double>();  // its sky's irradiance is of two orders
  const double r = Air{}.bottom_m;
  for (const double mu_s : {1.0, 0.6, 0.2, 0.05}) {
    glm::dvec3 sum(0.0);
    constexpr int kDirections = 4000;
    for (int k = 0; k < kDirections; ++k) {
      const double z = (k + 0.5) / kDirections, ring = std::sqrt(1.0 - z * z),
                   x = ring * std::cos(2.399963229728653 * k);
      const double nu = x * std::sqrt(1.0 - mu_s * mu_s) + z * mu_s;
      sum += 2.0 * kPi / kDirections * z * SkyRadiance(fewer, r, z, mu_s, nu, false);
    }
    const glm::dvec3 got = SkyIrradiance(tables, r, mu_s);
    EXPECT_LT(glm::length(got - sum), 0.04 * glm::length(sum)) << mu_s << ": " << got.z << ", not " << sum.z;
    const glm::dvec3 direct = GroundIrradiance(tables, mu_s) - got;
    EXPECT_LT(glm::length(direct - mu_s * AirOracle{Air{}}.ToSun(r, mu_s)), kEpsilon);
  }
}

// --- Precision, threads, files

TEST(AirTables, FloatsAreTheDoublesWithinTwoThousandths) {
  const AirTables<float>& tables = SmallTables<float>();
  const AirTables<double>& exact = SmallTables<double>();
  double most = 0.0;
  for (std::size_t i = 0; i < exact.scattering.size(); ++i) {
    const glm::dvec4 difference = glm::dvec4(tables.scattering[i]) - exact.scattering[i];
    for (int k = 0; k < 4; ++k) most = std::max(most, std::abs(difference[k]) / (0.01 + exact.scattering[i][k]));
  }
  EXPECT_LT(most, 2.0 * kEpsilon);
}

class Backwards final : public core::ParallelFor {
 public:
  void Run(std::size_t count, Body body, void* context) override {
    for (std::size_t i = count; i > 0; --i) body(context, i - 1);
  }
};

TEST(AirTables, AreTheSameWhateverTheOrderOfWork) {
  Backwards workers;
  AirTableSizes sizes{16, 8, 4, 16, 8, 4, 8, 4, 3};
  const auto one = MakeAirTables<float>(Air{}, sizes), other = MakeAirTables<float>(Air{}, sizes, &workers);
  EXPECT_EQ(one->scattering, other->scattering);
  EXPECT_EQ(one->irradiance, other->irradiance);
}

TEST(AirTables, TheProgressRisesToOneAndStopsTheWork) {
  const AirTableSizes sizes{16, 8, 4, 16, 8, 4, 8, 4, 3};
  double last = 0.0;
  EXPECT_TRUE(MakeAirTables<float>(Air{}, sizes, nullptr, [&](double share) {
    EXPECT_GT(share, last);
    last = share;
    return true;
  }));
  EXPECT_NEAR(last, 1.0, 1e-9);
  EXPECT_FALSE(MakeAirTables<float>(Air{}, sizes, nullptr, [](double share) { return share < 0.5; }));
}

class AirFile : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(file_); }
  AirTableSizes sizes_{16, 8, 4, 16, 8, 4, 8, 4, 2};
  std::filesystem::path file_ = std::filesystem::path(testing::TempDir()) / AirFileName(Air{}, sizes_);
};

TEST_F(AirFile, ComesBackAsItWas) {
  const AirTables<float> tables = *MakeAirTables<float>(Air{}, sizes_);
  ASSERT_TRUE(WriteAirTables(file_, tables));
  const auto read = ReadAirTables(file_, Air{}, sizes_);
  ASSERT_TRUE(read) << read.error().detail;
  EXPECT_EQ(read->transmittance, tables.transmittance);
  EXPECT_EQ(read->scattering, tables.scattering);
  EXPECT_EQ(read->irradiance, tables.irradiance);
}

TEST_F(AirFile, IsNeverTrustedWhenDamagedOrOfOtherAir) {
  ASSERT_TRUE(WriteAirTables(file_, *MakeAirTables<float>(Air{}, sizes_)));
  Air thick;
  thick.mie_g = 0.7;
  EXPECT_NE(AirFileName(thick, sizes_), AirFileName(Air{}, sizes_));
  EXPECT_EQ(ReadAirTables(file_, thick, sizes_).error().code, core::ErrorCode::kDamaged);
  const auto bytes = core::ReadFile(file_);
  ASSERT_TRUE(bytes);
  std::string wrong(bytes->begin(), bytes->end());
  for (const std::size_t at : {std::size_t{0}, std::size_t{9}, std::size_t{20}, wrong.size() / 2, wrong.size() - 1}) {
    wrong[at] = static_cast<char>(wrong[at] ^ 16);
    ASSERT_TRUE(core::WriteFile(file_, wrong));
    EXPECT_EQ(ReadAirTables(file_, Air{}, sizes_).error().code, core::ErrorCode::kDamaged) << at;
    wrong[at] = static_cast<char>(wrong[at] ^ 16);
  }
  ASSERT_TRUE(core::WriteFile(file_, wrong.substr(1)));
  EXPECT_EQ(ReadAirTables(file_, Air{}, sizes_).error().code, core::ErrorCode::kDamaged);
  std::filesystem::remove(file_);
  EXPECT_EQ(ReadAirTables(file_, Air{}, sizes_).error().code, core::ErrorCode::kNotFound);
}

// --- From outside

TEST(AirFromSpace, BringsThroughWhatTheNumericIntegralDoes) {
  const AirFromSpace air = AirFromSpace::From(SmallTables<float>());
  const AirOracle oracle{Air{}};
  const Shell<double> shell = AirMapping<double>{Air{}}.shell();
  for (const double miss_m : {0.3 * shell.bottom, 0.95 * shell.bottom, 0.999 * shell.bottom, shell.bottom + 5e3,
                              shell.bottom + 20e3, shell.bottom + 55e3}) {
    const double mu = -std::sqrt(1.0 - miss_m * miss_m / (shell.top * shell.top));
    const double d = miss_m < shell.bottom ? shell.DistanceToBottom(shell.top, mu) : shell.DistanceToTop(shell.top, mu);
    EXPECT_LT(glm::length(glm::dvec3(Through(air, miss_m)) - oracle.Transmittance(shell.top, mu, d, 2000)), 3e-3)
        << miss_m;
  }
}

class SunLightTest : public testing::Test {
 protected:
  // The sun's centre stands `above_rad` above the limb, at an altitude of 400 km.
  static glm::dvec3 Light(double above_rad, const AirFromSpace& air) {
    Surroundings space;
    const double distance_m = kEarthMeanRadius_m + 4e5, angle = std::asin(kEarthMeanRadius_m / distance_m) + above_rad;
    space.X_WE.translation = {0.0, 0.0, -distance_m};
    space.sun_direction_W = {std::sin(angle), 0.0, -std::cos(angle)};
    return SunLight(space, air);
  }
};

// The limb is nearly straight across the sun, so what is seen of it is a segment of a circle.
TEST_F(SunLightTest, UmbraAndPenumbraAreThoseOfTheDiscsGeometry) {
  const AirFromSpace vacuum = AirFromSpace::Vacuum();
  EXPECT_EQ(Light(-1.001 * kSunRadius_rad, vacuum).x, 0.0);
  EXPECT_NEAR(Light(1.001 * kSunRadius_rad, vacuum).x, 1.0, 1e-12);
  for (const double x : {-0.8, -0.4, 0.0, 0.3, 0.7}) {
    const double share = (std::acos(-x) + x * std::sqrt(1.0 - x * x)) / kPi;
    EXPECT_NEAR(Light(x * kSunRadius_rad, vacuum).y, share, 0.015) << x;
  }
  // The opposite way there is no Earth.
  EXPECT_EQ(Light(2.0, vacuum).x, 1.0);
}

TEST_F(SunLightTest, TheAirReddensTheSunBeforeItIsGone) {
  const AirFromSpace air = AirFromSpace::From(SmallTables<float>());
  const double limb_rad = 60e3 / 2.3e6;  // of the air's thickness, from 2300 km away
  EXPECT_NEAR(Light(1.5 * limb_rad, air).z, 1.0, 1e-6);
  const glm::dvec3 low = Light(0.3 * limb_rad, air), lower = Light(0.15 * limb_rad, air);
  EXPECT_LT(low.z, 0.9);
  EXPECT_GT(low.x, low.z);  // ozone takes more of the green than of both
  EXPECT_GT(lower.x / lower.z, low.x / low.z);
  EXPECT_EQ(Light(-2.0 * kSunRadius_rad, air).x, 0.0);
}

}  // namespace
}  // namespace space
