#include "vps/field/field_plan.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "vps/field/pack_facets.hpp"

namespace vps {
namespace {

// Memory, rounded up from measured builds: DistanceField.EstimatesItsMemoryFromAbove holds that it is enough, and at
// most 2.5 times as much as needed when no two bricks are alike.
constexpr double kBytesPerTriangle = 320.0;     // prepared triangles, their tree and their places in bricks
constexpr double kCreaseBytesPerBrick = 700.0;  // of finely tessellated surfaces
constexpr double kBytesPerFacet = 16.0;         // packed triangles, halved ones among them
constexpr double kFewBytes = 3e4;               // the empty brick, and grids rounded up
// The coarse grid is made coarser only while it takes more than both; neither is derived.
constexpr double kFewCoarseBytes = 1.5e6;   // stays in a second-level cache
constexpr double kCoarsePart = 1.0 / 20.0;  // of the bricks' bytes
constexpr int kMaxCoarseShift = 3;          // no larger than a brick: see RepairFarCells

int RoundUp(double value, int step) {
  return static_cast<int>(std::ceil(value / step)) * step;
}

// A brick is made when a sample of it lies within `band` of a triangle: when its centre lies in the triangle's sum
// with the box of samples (7 voxels wide) and the ball. Of a surface of area A and normal n that sum has the volume
// A (2 band + 7 |n|_1), of an edge of length l at most l (2 band + 7)^2 / 4, and there is a centre per 512 voxels.
// Edges are counted as those of the box around the mesh; curvature and gaps are left to the margin.
double EstimateBricks(const TriangleMesh& mesh, double voxel_size_m, double band, const glm::dvec3& size) {
  const double side = DistanceField::kBrick - 1;
  double volume = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.corners(i);
    const glm::dvec3 n = 0.5 * glm::cross(b - a, c - a) / (voxel_size_m * voxel_size_m);  // area times unit normal
    volume += 2.0 * band * glm::length(n) + side * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
  }
  const double width = 2.0 * band + side;
  const double edges = 4.0 * (size.x + size.y + size.z) * width * width / 4.0 + width * width * width;
  constexpr double kMargin = 1.15;  // not derived; the same test
  return kMargin * (volume + edges) / DistanceField::kBrickWords;
}

}  // namespace

core::Result<FieldPlan> PlanField(const TriangleMesh& mesh, double voxel_size_m, const BuildFieldOptions& options) {
  if (!(voxel_size_m > 0.0) || !std::isfinite(voxel_size_m)) {
    return core::Fail(core::ErrorCode::kInvalidInput, "the voxel size must be positive");
  }
  if (mesh.triangles.empty()) return core::Fail(core::ErrorCode::kInvalidInput, "the mesh has no triangles");
  FieldPlan plan;
  const Box box = BoundingBox(mesh);
  const glm::dvec3 size = (box.upper - box.lower) / voxel_size_m;
  const double border = std::max<double>(DistanceField::kMinBorder, std::ceil(DistanceField::kBorder_m / voxel_size_m));
  const glm::dvec3 wanted = glm::ceil(size) + 2.0 * border;
  const double num_voxels = wanted.x * wanted.y * wanted.z;

  // The finest coarse grid that stays small beside the bricks.
  const double bricks =
      std::min(EstimateBricks(mesh, voxel_size_m, DistanceField::kBandVoxels, size), 2.0 * num_voxels / 512.0 + 8.0);
  const double brick_bytes = bricks * DistanceField::kBrickWords * sizeof(std::uint32_t);
  DistanceField& layout = plan.layout;
  const auto coarse_bytes = [&] { return num_voxels / std::pow(8.0, layout.coarse_shift) * sizeof(CoarseCell); };
  while (coarse_bytes() > std::max(kFewCoarseBytes, kCoarsePart * brick_bytes) &&
         layout.coarse_shift < kMaxCoarseShift) {
    ++layout.coarse_shift;
  }
  const double index_bytes = num_voxels / DistanceField::kBrickWords * sizeof(std::uint32_t);
  const double creases = bricks * kCreaseBytesPerBrick;
  plan.estimate.stored_bytes = kFewBytes + brick_bytes + creases + index_bytes + coarse_bytes();
  plan.estimate.stored_bytes += std::min(kBytesPerFacet * static_cast<double>(mesh.triangles.size()),
                                         kMostFacetsShare * plan.estimate.stored_bytes);
  // Words and creases exist twice for a moment, when their vectors are shrunk to fit.
  plan.estimate.peak_bytes = plan.estimate.stored_bytes + std::max(creases, brick_bytes) +
                             kBytesPerTriangle * static_cast<double>(mesh.triangles.size());
  if (!(plan.estimate.peak_bytes <= options.max_peak_bytes) || !(std::max({wanted.x, wanted.y, wanted.z}) < 1e6)) {
    char text[256];
    std::snprintf(text, sizeof(text),
                  "a voxel size of %g m takes %.3g x %.3g x %.3g voxels and about %.3g MB of memory, more than the "
                  "%.3g MB allowed: take a larger one, or check that the mesh is in metres",
                  voxel_size_m, wanted.x, wanted.y, wanted.z, 1e-6 * plan.estimate.peak_bytes,
                  1e-6 * options.max_peak_bytes);
    return core::Fail(core::ErrorCode::kResource, text);
  }
  const int step = std::max(DistanceField::kBrick, 1 << layout.coarse_shift);
  layout.voxel_size_m = voxel_size_m;
  layout.nx = RoundUp(wanted.x, step);
  layout.ny = RoundUp(wanted.y, step);
  layout.nz = RoundUp(wanted.z, step);
  layout.origin_m = 0.5 * (box.lower + box.upper) - 0.5 * voxel_size_m * glm::dvec3(layout.nx, layout.ny, layout.nz);
  return plan;
}

core::Result<FieldEstimate> EstimateField(const TriangleMesh& mesh, double voxel_size_m,
                                          const BuildFieldOptions& options) {
  const auto plan = PlanField(mesh, voxel_size_m, options);
  if (!plan) return tl::unexpected(plan.error());
  return plan->estimate;
}

}  // namespace vps
