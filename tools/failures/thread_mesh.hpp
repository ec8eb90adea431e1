#pragma once

#include "vps/mesh/triangle_mesh.hpp"

namespace failures {

// A right-handed thread about z with the basic profile of ISO 68-1, centred on the origin.
struct Thread {
  double major_m = 0.008;  // radius
  double pitch_m = 0.002;
};

vps::TriangleMesh MakeBolt(const Thread& thread, double length_m);
// A ring round it. Its thread is that of the bolt, `gap_m` farther out.
vps::TriangleMesh MakeNut(const Thread& thread, double gap_m, double outer_m, double length_m);

}  // namespace failures
