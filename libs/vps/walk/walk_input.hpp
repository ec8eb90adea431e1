#pragma once

#include "core/pose.hpp"
#include "vps/field/distance_field.hpp"
#include "vps/walk/field_walk.hpp"
#include "vps/walk/walk_kernel.hpp"

namespace vps {

// The kernels that were compiled for `set`; portable ones where the machine is another.
WalkKernels KernelsOf(InstructionSet set);

// The field's part of a kernel's input, with the transform of the points; everything else is zero.
WalkInput MakeFieldInput(const DistanceField& field, const core::Pose& X_GS);

}  // namespace vps
