#pragma once

#include <string_view>
#include <vector>

#include "core/pose.hpp"
#include "vps/mesh/triangle_mesh.hpp"
#include "vps/testing/case_random.hpp"

namespace vps {

// Ways in which two parts touch. Depths are shares of the size: the smaller part's longest side.
enum class PoseKind {
  kLight,    // from a random side at a random attitude, 1e-5 to 1e-3 beyond the first touch
  kMedium,   // the same, 1e-3 to 1e-2
  kDeep,     // the same, 2e-2 to 1e-1
  kSliding,  // steps of 1e-3 along the surface from one light contact
  kFlat,     // face to face, 1e-5 to 1e-3 deep; every second one tilted by 1e-4 to 1e-2 rad
  kEdge,     // a sharp edge that lies on a face, 1e-4 to 1e-3 deep: B's edges and A's in turn
  kPressed,  // a peg in its hole, pressed aside, 1e-5 to 1e-3 beyond the first touch (MakePressedPoses)
};
constexpr int kNumPoseKinds = 7;
std::string_view ToText(PoseKind kind);

struct ContactPose {
  PoseKind kind = PoseKind::kLight;
  core::Pose X_AB;
};

// `count_each` poses of every kind but kPressed, by the exact distances of vps/oracle. Fewer where B passes through A
// without a touch, a part has no sharp edge, or a face or edge cannot be reached because something else is in the way.
// A sliding part may have left the other.
std::vector<ContactPose> MakeContactPoses(const TriangleMesh& A, const TriangleMesh& B, int count_each,
                                          CaseRandom* random);

// A peg B and a hole A, both along z, that do not touch at X_AB = X_start, and the radial clearance: `count` poses
// kPressed, each turned about z, shifted along z by up to `travel_m`, tilted by no more than the clearance allows, and
// pressed aside.
struct PegFit {
  core::Pose X_start;
  double clearance_m = 0.0;
  double travel_m = 0.0;
};
std::vector<ContactPose> MakePressedPoses(const TriangleMesh& A, const TriangleMesh& B, const PegFit& fit, int count,
                                          CaseRandom* random);

}  // namespace vps
