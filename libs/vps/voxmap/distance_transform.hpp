#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace vps {

// Squared Euclidean distance, in voxels, from each voxel's centre to the nearest centre of a voxel with state == mark,
// exact up to kDistanceLimit and kDistanceLimit^2 beyond. Separable: distances along x, then the lower envelope of
// parabolas along y and z (Meijster et al. 2000). Linear in the number of voxels. The limit is one more than
// Voxmap::kMaxLayer, where layers saturate. `state` and the result are [(z * ny + y) * nx + x]; `progress` gets the
// share done, in [0, 1].
constexpr int kDistanceLimit = 128;
std::vector<std::uint16_t> SquaredDistances(const std::vector<std::uint8_t>& state, std::uint8_t mark, int nx, int ny,
                                            int nz, const std::function<void(double)>& progress);

}  // namespace vps
