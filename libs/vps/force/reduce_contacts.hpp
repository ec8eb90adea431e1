#pragma once

#include <cstdint>
#include <span>

#include "core/fixed_vector.hpp"
#include "core/messages/haptic.hpp"
#include "core/pose.hpp"

namespace vps {

// A point of S near or inside G.
struct SampledContact {
  glm::vec3 p_S{0.0f};         // m
  glm::vec3 n_S{0.0f};         // inward normal of S at the point: the direction from G to S
  float penetration_m = 0.0f;  // V(P) [VR-OOS, Eq. 1]; negative: still apart
};

using ContactPlanes = core::FixedVector<core::ContactPlane, core::kMaxContactPlanes>;

// Reduces any number of contacts to a few planes (architecture D5). Contacts are sorted by the direction of their
// normal in G into 26 bins (faces, edges, corners of a cube). A bin is represented by its deepest contact and by the
// contacts that lie farthest out in four directions of its tangent plane and within `band_m` of the deepest, so that a
// face cannot rock; its planes share `stiffness_N_per_m` in equal parts. Bins with the deepest contacts come first;
// when planes run out, shallower bins lose their outer contacts, never their deepest, and the shallowest bins are left
// out. Ids are bin and slot, so they are the same from cycle to cycle as long as the direction stays in contact.
// Independent of the order of `contacts` up to ties. Does not allocate.
void ReduceContacts(std::span<const SampledContact> contacts, const core::Pose& X_GS, double stiffness_N_per_m,
                    double band_m, ContactPlanes* planes);

}  // namespace vps
