#pragma once

#include <span>

#include "vps/force/reduce_contacts.hpp"

namespace vps {

// A point of S near or inside G, or some neighbouring ones, with their share of the penalty integral.
struct ContactPatch {
  glm::vec3 p_S{0.0f};         // of the deepest of its points, m
  glm::vec3 n_G{0.0f};         // the field's gradient there, about unit: direction from G to S, in G
  float penetration_m = 0.0f;  // there; negative: still apart
  // Over the patch's surface inside G, about S's mesh origin, in S; zero while apart.
  glm::vec3 force_m3{0.0f};  // integral of depth times inward normal
  glm::vec3 moment_m4{0.0f};
  float volume_m3 = 0.0f;  // integral of depth
  float square_m4 = 0.0f;  // integral of its square
};

// What the planes must add up to, in S, about S's mesh origin.
struct ContactLoad {
  glm::dvec3 force_m3{0.0};
  glm::dvec3 moment_m4{0.0};
  double volume_m3 = 0.0;
  double modulus_N_per_m3 = 0.0;  // the force is this times force_m3
};

// Reduces any number of patches to a few planes (architecture D5) of two kinds.
//
// Load planes carry the integral: stiffness times depth times normal, summed over them, is the given force, and so is
// the moment. Patches are grouped by the direction of n in G (DirectionBin), and a group wider than `width_m` is cut in
// two or four across its middle. Each group, or part of one, becomes a plane:
//
//   n  direction of the whole group's force, so that a face stays flat
//   f  component of its patches' force along n [m^3]
//   d  = (integral of depth^2) / (integral of depth), its depth [m]
//   k  = modulus |f| / d, its stiffness [N/m]: the modulus times the area that carries, so that all planes together
//   have
//      the pair's stiffness
//   p  point on the axis of f
//
// Cutting and sideways components change the sums a little. The force l and the moment m that are
// missing are distributed with weights w_i = |f_i| / sum |f|, r_i from the mean place:
//
//   df_i = w_i (l + a x r_i)   with   sum df_i = l,   sum r_i x df_i = [sum w (r^2 I - r r^T)] a = m.
//
// Guard planes have positive gaps and carry nothing yet: of each direction the nearest patch and those that lie
// farthest out in four directions, within `band_m` of the deepest; the stiffness of ReduceContacts.
//
// Every direction has a plane before one has several; then load goes before guards. Ids are bin and slot: the same from
// cycle to cycle while the direction stays in contact. `planes` holds the result of the last cycle on entry: a group
// that was cut stays cut down to 0.7 of the width, and guards keep their slots unless another is better by more than
// `hysteresis_m` (four times that for reach). At most kMaxPatches (not derived: bounds memory and time; walks hand over
// fewer). Does not allocate.
constexpr std::size_t kMaxPatches = 512;
void ReducePatches(std::span<const ContactPatch> patches, const core::Pose& X_GS, const ContactLoad& load,
                   double stiffness_N_per_m, double band_m, double width_m, ContactPlanes* planes,
                   double hysteresis_m = 0.0);

}  // namespace vps
