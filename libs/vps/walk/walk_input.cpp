#include <cstring>

#include "vps/walk/field_walk.hpp"

namespace vps {

WalkKernels KernelsOf([[maybe_unused]] InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::kAvx512) return Avx512WalkKernels();
  if (set == InstructionSet::kAvx2) return Avx2WalkKernels();
#endif
  return PortableWalkKernels();
}

WalkInput MakeFieldInput(const DistanceField& field, const core::Pose& X_GS) {
  const FieldTransform T(X_GS, field);
  WalkInput in{};
  in.bricks = field.bricks.data();
  in.words = field.words.data();
  in.creases = field.creases.data();
  in.coarse = field.coarse.data();
  in.curvatures = reinterpret_cast<const std::uint32_t*>(field.curvatures.data());
  const Facets& facets = field.triangles();
  in.facet_blocks = facets.blocks.data();
  in.facet_spheres = facets.spheres.data();
  in.facet_level_begin = facets.level_begin.data();
  in.num_facet_levels = facets.num_levels;
  in.nx = field.nx;
  in.ny = field.ny;
  in.nz = field.nz;
  in.coarse_shift = field.coarse_shift;
  std::memcpy(in.m, T.m, sizeof in.m);
  std::memcpy(in.t, T.t, sizeof in.t);
  in.voxels_per_m = static_cast<float>(1.0 / field.voxel_size_m);
  in.m_per_voxel = static_cast<float>(field.voxel_size_m);
  return in;
}

}  // namespace vps
