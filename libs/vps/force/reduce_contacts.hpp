#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "core/fixed_vector.hpp"
#include "core/messages/haptic.hpp"
#include "core/pose.hpp"

namespace vps {

// A point of S near or inside G.
struct SampledContact {
  glm::vec3 p_S{0.0f};         // m
  glm::vec3 n_S{0.0f};         // unit, direction from G to S, in S
  float penetration_m = 0.0f;  // V(P) [VR-OOS, Eq. 1]; negative: still apart
};

using ContactPlanes = core::FixedVector<core::ContactPlane, core::kMaxContactPlanes>;

// Reduces any number of contacts to a few planes (architecture D5). Contacts are sorted by the direction of their
// normal in G into 26 bins (faces, edges, corners of a cube). A bin is represented by its deepest contact and by the
// contacts that lie farthest out in four directions of its tangent plane and within `band_m` of the deepest, so that a
// face cannot rock. All planes of a bin have the mean normal of its contacts, weighted by how near they are to the
// deepest: a single normal carries the rounding of the layers. Together they have `stiffness_N_per_m`, those that
// penetrate an equal share each, those still apart less with distance. Positions in S's mesh frame, normals and the
// planes' points in G's, metres.
// Bins with the deepest contacts come first; when planes run out, shallower bins lose their outer contacts, never their
// deepest, and the shallowest bins are left out. Ids are bin and slot, so they are the same from cycle to cycle as long
// as the direction stays in contact. `planes` holds the result of the last cycle on entry: its contacts keep their
// slots unless another is better by more than `hysteresis_m` (four times that for reach). Does not allocate.
void ReduceContacts(std::span<const SampledContact> contacts, const core::Pose& X_GS, double stiffness_N_per_m,
                    double band_m, ContactPlanes* planes, double hysteresis_m = 0.0);

// Of the stiffness, the share of a plane that is still apart, by its negative penetration: it rises linearly to 1 over
// the last quarter of the band. The least share is not derived: more takes stiffness from the planes in contact, less
// makes a new contact softer in its first cycle.
constexpr double kLeastShare = 0.05;
template <class Real>
Real GuardShare(Real penetration_m, Real band_m) {
  return std::clamp(Real(1) + penetration_m / (Real(0.25) * band_m + Real(1e-9)), static_cast<Real>(kLeastShare),
                    Real(1));
}

}  // namespace vps
