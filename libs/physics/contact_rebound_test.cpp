// Undamped rebounds under delay: total energy after over before, for flat, edge and curved contact with rotation.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "physics/testing/trials/rebound.hpp"

namespace physics {
namespace {

using trials::ReboundInput;
using trials::ReboundParams;
using trials::ReboundShape;

double Ratio(ReboundShape shape, double mass, double spin, int delay, ReboundInput input = ReboundInput::kPlanes) {
  ReboundParams params;
  params.shape = shape;
  params.input = input;
  params.mass_kg = mass;
  params.spin_rad_per_s = spin;
  params.delay_ms = delay;
  return trials::ReboundRatio(params);
}

struct Case {
  const char* name;
  ReboundShape shape;
};
const Case kCases[] = {{"flat", ReboundShape::kFlat},
                       {"edge", ReboundShape::kEdge},
                       {"ball", ReboundShape::kBall},
                       {"balls", ReboundShape::kBalls},
                       {"vertex", ReboundShape::kVertex}};

constexpr double kMasses_kg[] = {0.2, 2.0, 20.0};
constexpr int kDelays[] = {0, 1, 3, 7};  // ms

TEST(Rebound, KeepsEnergyWithoutDelayHoweverTheBodiesTurn) {
  for (const Case& c : kCases) {
    for (const double mass : kMasses_kg) {
      for (const double spin : {0.0, 2.0, 10.0}) {
        EXPECT_NEAR(Ratio(c.shape, mass, spin, 0), 1.0, 1e-3) << c.name << ", " << mass << " kg, " << spin << " rad/s";
      }
    }
  }
}

TEST(Rebound, StaysWithinTwoPercentUnderDelayOfThePlanes) {
  for (const Case& c : kCases) {
    double least = 1e9;
    double most = 0.0;
    for (const double mass : kMasses_kg) {
      for (const int delay : kDelays) {
        for (const double spin : {0.0, 2.0}) {  // rad/s
          const double ratio = Ratio(c.shape, mass, spin, delay);
          least = std::min(least, ratio);
          most = std::max(most, ratio);
          EXPECT_NEAR(ratio, 1.0, 0.02) << c.name << ", " << mass << " kg, " << delay << " ms, " << spin << " rad/s";
        }
      }
    }
    RecordProperty(c.name, std::to_string(least) + " to " + std::to_string(most));
  }
}

TEST(Rebound, OfPassiveContactsKeepsEnergyWithoutDelay) {
  for (const Case& c : kCases) {
    for (const double mass : kMasses_kg) {
      for (const double spin : {0.0, 2.0, 10.0}) {
        EXPECT_NEAR(Ratio(c.shape, mass, spin, 0, ReboundInput::kPassive), 1.0, 1e-3)
            << c.name << ", " << mass << " kg, " << spin << " rad/s";
      }
    }
  }
}

TEST(Rebound, OfPassiveContactsMakesNoEnergyUnderDelay) {
  for (const Case& c : kCases) {
    for (const double mass : kMasses_kg) {
      for (const int delay : kDelays) {
        for (const double spin : {0.0, 2.0}) {  // rad/s
          const double ratio = Ratio(c.shape, mass, spin, delay, ReboundInput::kPassive);
          EXPECT_LE(ratio, 1.0 + 1e-6) << c.name << ", " << mass << " kg, " << delay << " ms, " << spin << " rad/s";
          EXPECT_GE(ratio, 0.98) << c.name << ", " << mass << " kg, " << delay << " ms, " << spin << " rad/s";
        }
      }
    }
  }
}

}  // namespace
}  // namespace physics
