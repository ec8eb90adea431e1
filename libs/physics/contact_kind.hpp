#pragma once

#include <cstdint>

namespace physics {

// Law of a pair's planes. Friction is Coulomb's in all.
enum class ContactKind : std::uint8_t {
  kCompliant,  // springs, which conserve energy; what sticks does not move
  kPassive,    // the same, but they give back no more energy than was put into them
  kElastic,    // the same, but what sticks hangs on a spring: q_G, moved along the plane, is where p_S sticks
  kHard,       // prevents penetration and dissipates the energy of the approach
};

}  // namespace physics
