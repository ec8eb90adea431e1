#pragma once

#include "core/pose.hpp"
#include "vps/oracle/contact_wrench.hpp"

namespace vps {

// The wrench that methods are compared with, in A's frame, moments about B's mesh origin: vps/oracle's adaptive
// integral of max(depth, 0) n dA over B's surface, refined until the sum of all pieces' last changes is below 3e-4 of
// the force (WrenchAccuracy). The sum counts every change as if all had one sign, and a change is that of a rule of
// degree 4 from a piece to its four parts; so that what remains is mostly corners that lie between samples and are not
// seen. ReferenceWrench.MovesByLessThanATenthOfAPercentWhenRefined says how much that is. The floor,
// 1e-21 of area times radius, is far below the lightest contact. Where opposite sides press and the pieces run out, the
// sum below 3e-4 of the integral of depth suffices, since errors are shares of that. `has_converged` false: no
// reference.
oracle::ContactWrench ReferenceWrench(const oracle::MeshDistance& A, const oracle::MeshDistance& B,
                                      const core::Pose& X_AB);

// What a method's force F and moment M are off, with the reference F0, M0, the integral of depth I, and B's radius r
// (the greatest distance of its surface from its origin):
//   force = |F - F0| / I,   moment = |M - M0| / (I r),   direction = angle of F and F0 [rad].
// I is what the force would be if all of the surface pressed in one direction, so that almost nothing is not divided by
// almost nothing where opposite sides press against each other. The force is compared as a vector: a wrong direction
// counts, and an error of the size alone is never more. No direction is compared where |F0| is less than I / 10 (NaN),
// nor where F is zero.
struct WrenchError {
  double force = 0.0;
  double moment = 0.0;
  double direction_rad = 0.0;
};
WrenchError CompareWrench(const glm::dvec3& force_A_m3, const glm::dvec3& moment_A_m4,
                          const oracle::ContactWrench& reference, double radius_B_m);

// Greatest distance of the mesh's vertices from its origin [m].
double RadiusAboutOrigin_m(const TriangleMesh& mesh);

}  // namespace vps
