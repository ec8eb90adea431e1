#pragma once

#include "core/result.hpp"
#include "vps/field/build_field.hpp"

namespace vps {

// The grid of a field, and the memory that it takes.
struct FieldPlan {
  DistanceField layout;  // origin, voxel size, counts; no cells yet
  FieldEstimate estimate;
};
core::Result<FieldPlan> PlanField(const TriangleMesh& mesh, double voxel_size_m, const BuildFieldOptions& options);

}  // namespace vps
