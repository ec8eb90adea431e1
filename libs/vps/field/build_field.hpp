#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "core/parallel_for.hpp"
#include "core/result.hpp"
#include "vps/field/closest_triangle.hpp"
#include "vps/field/distance_field.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

struct BuildFieldOptions {
  Signs signs = Signs::kNormals;
  // A build whose estimated peak is larger is refused before anything is allocated.
  double max_peak_bytes = 8e9;
  // Share the work; null: the calling thread does all of it. The field is the same, bit for bit.
  core::ParallelFor* workers = nullptr;
  // Called on the calling thread, at most some hundred times, with the share of the build's time that is done, in [0,
  // 1].
  std::function<void(std::string_view stage, double fraction)> progress{};
};

// Upper estimate of a build's memory from the mesh's area and size, in time proportional to its triangles. Equal bricks
// are stored once: a part with flat faces along the grid takes less, down to a tenth.
struct FieldEstimate {
  double stored_bytes = 0.0;  // of the field
  double peak_bytes = 0.0;    // while it is built, field included, mesh not
};
core::Result<FieldEstimate> EstimateField(const TriangleMesh& mesh, double voxel_size_m,
                                          const BuildFieldOptions& options = {});

// Builds the field of a mesh. Errors: no triangle, voxel size not positive (kInvalidInput); more memory than allowed
// (kResource).
core::Result<DistanceField> BuildField(const TriangleMesh& mesh, double voxel_size_m,
                                       const BuildFieldOptions& options = {});

}  // namespace vps
