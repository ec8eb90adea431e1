#pragma once

#include "vps/walk/field_walk.hpp"

namespace contact {

// Conservative lower bound [voxels] of the exact signed distance at p (in the field's voxels): the field's distance
// less its error bound there.
float LowerBoundOfDistance(const vps::DistanceField& field, const glm::vec3& p);

// Conservative lower bound [m] of the distance between the surfaces of S (sampled) and G (field), 0 when no positive
// bound is found. A place x of S lies within the support radius r_i of a sample p_i, and distances are 1-Lipschitz, so
// d(x) >= LowerBoundOfDistance(p_i) - r_i; near G the finer samples of FineBlock replace p_i. Branch and bound down the
// sphere tree, nearest first, to a relative tolerance of 1/50. Allocates.
double ApartBound_m(const vps::SampleTree& sampled, const vps::DistanceField& field, const core::Pose& X_GS);

}  // namespace contact
