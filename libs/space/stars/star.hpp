#pragma once

#include <glm/glm.hpp>

namespace space {

struct Star {
  glm::dvec3 direction_C{0.0, 0.0, 1.0};  // unit; place at J2000.0 in the celestial frame
  double magnitude = 0.0;                 // visual, V
  double color_bv = 0.7;                  // colour index B - V
};

// Illuminance of a star at the eye [lx]: 2.54e-6 lx at magnitude 0, which is a luminance of 10.8e4 cd/m2 at magnitude 0
// per square arc second, as CosmoScout VR has it.
double Illuminance_lx(double magnitude);

// Linear RGB (sRGB's primaries) of luminance 1: a black body of the star's temperature [Ballesteros 2012], its place on
// the Planckian locus by [Kim et al. 2002].
glm::dvec3 ColorOf(double color_bv);

}  // namespace space
