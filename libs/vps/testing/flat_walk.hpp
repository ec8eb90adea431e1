#pragma once

#include "vps/walk/field_walk.hpp"

namespace vps {

// What WalkField must find: every point, one after the other, with SampleField.
FieldWalkResult WalkFieldFlat(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                              double margin_m);

}  // namespace vps
