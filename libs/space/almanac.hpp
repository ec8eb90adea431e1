#pragma once

#include <glm/glm.hpp>

#include "space/instant.hpp"

namespace space {

// Where the sun and the Moon are and how the Earth is turned, by the IAU's standard routines (ERFA, the library that
// astropy uses).
//
// Frames: C is the celestial frame (GCRS: axes of the International Celestial Reference Frame, origin at the Earth's
// centre), E is fixed in the Earth (ITRS: z the pole, x Greenwich on the equator).
//
// Left out: UT1 - UTC (below 0.9 s, 0.004 degrees of the Earth's rotation) and the motion of the pole (0.0002 degrees).
// Both are measured, not computed, and come from bulletins.

// Apparent direction from the Earth's centre to the sun: with light time and aberration, as its light arrives.
glm::dvec3 SunDirection_C(const Instant& instant);

// From the Earth's centre to the Moon's [m].
glm::dvec3 MoonPosition_C(const Instant& instant);

// R_CE, in two factors: precession and nutation, which hardly change within a day, and the turn about the pole.
glm::dmat3 CelestialPole(const Instant& instant);       // R_CI
double EarthRotationAngle_rad(const Instant& instant);  // R_IE = Rz(angle)
glm::dmat3 EarthOrientation_C(const Instant& instant);  // R_CE = R_CI R_IE

}  // namespace space
