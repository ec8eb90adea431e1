#pragma once

#include <cstdint>

#include "core/pose.hpp"
#include "vps/oracle/mesh_distance.hpp"

namespace vps::oracle {

// Wrench on B per unit modulus, in A's frame, with the depth d [m] of B's surface points x in A, B's inward normal n
// and B's mesh origin o:
//   force = integral over B's surface inside A of d n dA [m^3],   moment = integral of (x - o) x d n dA [m^4].
struct ContactWrench {
  glm::dvec3 force_A_m3{0.0};
  glm::dvec3 moment_A_m4{0.0};
  double depth_integral_m3 = 0.0;  // integral of d dA, without cancellation between opposite sides
  double area_m2 = 0.0;            // of the pieces of B's surface where depth was found: an upper estimate
  double error_bound_m3 = 0.0;     // sum over pieces of what the last refinement changed; the force moved by no more
  std::uint64_t num_samples = 0;
  std::uint64_t num_pieces_with_depth = 0;
  bool has_converged = true;  // false: the number of pieces ran out first
};

struct WrenchAccuracy {
  // Refined until the sum of all pieces' changes, signs dropped, is below this fraction of the greater of |force| and
  // one hundredth of depth_integral, or below `floor` times B's area times its radius.
  double relative = 1e-4;
  std::uint32_t max_pieces = 400'000;
  double floor = 1e-10;
};

// Adaptive quadrature: B's triangles are split until they are inside, outside, or small, with a rule of degree 4 on
// each piece. Pieces that do not meet A's surface are classified once, so that nothing is missed between samples.
ContactWrench IntegrateContactWrench(const MeshDistance& A, const MeshDistance& B, const core::Pose& X_AB,
                                     const WrenchAccuracy& accuracy = {});

}  // namespace vps::oracle
