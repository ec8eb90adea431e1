#pragma once

#include <memory>

#include "vps/asset/cooked_object.hpp"

namespace vps {

// Voxels of 0 m: no field side; 0 points: no sampled side. The mesh is known to be good.
inline std::shared_ptr<const CookedObject> Cooked(const TriangleMesh& mesh, double voxel_size_m,
                                                  std::uint32_t num_points, Method method = Method::kPaper) {
  return std::make_shared<const CookedObject>(*Cook(mesh, {voxel_size_m, num_points, method}));
}

}  // namespace vps
