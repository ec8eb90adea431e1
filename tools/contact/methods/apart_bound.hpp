#pragma once

#include "vps/walk/field_walk.hpp"

namespace contact {

// Lower bound of the true distance of a place (in the field's voxels), in voxels: what the field says less what it may
// be off by there.
float DistanceAtLeast(const vps::DistanceField& field, const glm::vec3& p);

// No place of S's surface is nearer to G's than this; 0 when the samples cannot tell. Every place is as near as the
// bound at the point that stands for it, less how far it may be from that; the samples nearest to G are taken finer
// (FineBlock). Best first down the tree, until nothing can be nearer by more than a fiftieth. Allocates.
double ApartBound_m(const vps::SampleTree& sampled, const vps::DistanceField& field, const core::Pose& X_GS);

}  // namespace contact
