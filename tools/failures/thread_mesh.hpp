#pragma once

#include "vps/mesh/triangle_mesh.hpp"

namespace failures {

// A right-handed thread about z with the basic profile of ISO 68-1, centred on the origin.
struct Thread {
  double major_m = 0.008;  // radius
  double pitch_m = 0.002;
};

// Nut and bolt that the rows of F20 are measured with.
struct ThreadFit {
  const char* name;
  Thread thread;
  double gap_m;
};
constexpr ThreadFit kThreadFits[] = {{"M16, 0.1 mm of play", {0.008, 0.002}, 1e-4},
                                     {"M20, 0.3 mm of play", {0.010, 0.0025}, 3e-4}};

vps::TriangleMesh MakeBolt(const Thread& thread, double length_m);
// A ring round it. Its thread is that of the bolt, `gap_m` farther out.
vps::TriangleMesh MakeNut(const Thread& thread, double gap_m, double outer_m, double length_m);

}  // namespace failures
