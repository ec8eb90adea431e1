#include "vps/testing/brute_force.hpp"

#include "vps/query/pair_transform.hpp"

namespace vps {

std::vector<PointHit> QueryBruteForce(const PointTree& sampled, const Voxmap& field, const core::Pose& X_GS,
                                      double margin_m) {
  const PairTransform T(X_GS, field);
  const auto margin = static_cast<float>(margin_m);
  std::vector<PointHit> hits;
  for (std::uint32_t i = 0; i < sampled.num_points; ++i) {
    float p[3];
    int cell[3];
    const float q[3] = {sampled.x[i], sampled.y[i], sampled.z[i]};
    const float n[3] = {sampled.nx[i], sampled.ny[i], sampled.nz[i]};
    for (int k = 0; k < 3; ++k) p[k] = T.m[k][0] * q[0] + T.m[k][1] * q[1] + T.m[k][2] * q[2] + T.t[k];
    if (!(p[0] >= 0.0f && p[1] >= 0.0f && p[2] >= 0.0f)) continue;
    for (int k = 0; k < 3; ++k) cell[k] = static_cast<int>(std::min(p[k], 1e9f));
    if (!field.contains(cell[0], cell[1], cell[2])) continue;
    // V(P) = v s + n . e, e from the point to the centre of its voxel [VR-OOS, Eq. 1].
    float local = 0.0f;
    for (int k = 0; k < 3; ++k) {
      const float n_G = T.r[k][0] * n[0] + T.r[k][1] * n[1] + T.r[k][2] * n[2];
      local += n_G * (static_cast<float>(cell[k]) + 0.5f - p[k]);
    }
    const float penetration_m = (static_cast<float>(field.at(cell[0], cell[1], cell[2])) + local) * T.voxel_size_m;
    if (penetration_m >= -margin) hits.push_back({i, penetration_m});
  }
  return hits;
}

}  // namespace vps
