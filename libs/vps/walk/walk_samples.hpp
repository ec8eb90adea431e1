// Samples and their finer points; included by walk_lanes.hpp after walk_points.hpp. What is done with the results is in
// multibody/refine_contact.cpp.

// kBlock floats in registers.
struct Row {
  F of[kParts];
};
inline Row LoadRow(const float* p) {
  Row row;
  for (int j = 0; j < kParts; ++j) row.of[j] = LoadF(p + j * kLanes);
  return row;
}
inline void StoreRow(float* p, const Row& row) {
  for (int j = 0; j < kParts; ++j) StoreF(p + j * kLanes, row.of[j]);
}
inline float MostOf(const Row& row) {
  F most = row.of[0];
  for (int j = 1; j < kParts; ++j) most = Max(most, row.of[j]);
  return Most(most);
}
inline float LeastOf(const Row& row) {
  F least = row.of[0];
  for (int j = 1; j < kParts; ++j) least = Min(least, row.of[j]);
  return Least(least);
}
inline F UpToOne(F v) {
  return v > 0.0f ? (v < 1.0f ? v : Fill(1.0f)) : F{};
}
inline F SharesNear(F depth, const NearRange& range) {
  return UpToOne((depth + range.outside) * range.per_fade);
}

// Weights of a block's samples: 0 where the depth d < -r, with r = steep * (radius of the patch) the reach of the patch
// towards G, 1 from d = -r / sqrt(2) on,
//   weight = clamp(2 (r^2 - d^2) / r^2, 0, 1)   for d < 0.
// The slope of the depth, which r is estimated with, is that of the samples of the block: in a conforming contact the
// whole free side is nearer than its samples are to each other.
inline void WeighBlock(const WeighInput& in, const PointBlock& block, const float* depths, float radius_m,
                       NearBlock* near) {
  const Row depth = LoadRow(depths);
  const Row area = LoadRow(block.area_m2);
  Row low;
  Row high;
  for (int j = 0; j < kParts; ++j) {
    const I is_point = area.of[j] > 0.0f;
    low.of[j] = is_point ? depth.of[j] : Fill(1e30f);
    high.of[j] = is_point ? depth.of[j] : Fill(-1e30f);
  }
  const float least = LeastOf(low);
  const float most = MostOf(high);
  const float slope = (most - least) * in.m_per_voxel / (2.0f * radius_m);
  const float steep = in.steeper * slope + in.least_slope < 1.0f ? in.steeper * slope + in.least_slope : 1.0f;
  // Of a face along G's no sample reaches it.
  const float most_m = most * in.m_per_voxel;
  if (most < 0.0f && !(most > -in.unrefined.outside) && most_m * most_m >= in.most_m2 * (steep * steep)) {
    near->weight = near->inside = near->unrefined = 0.0f;
    return;
  }
  Row weight;
  Row inside;
  for (int j = 0; j < kParts; ++j) {
    const F depth_m = depth.of[j] * in.m_per_voxel;
    const F outside_m = depth_m < 0.0f ? depth_m : F{};
    const F patch_m2 = area.of[j] * (kPatchReach * kPatchReach);
    const F reach_m2 = (patch_m2 < in.most_m2 ? patch_m2 : Fill(in.most_m2)) * (steep * steep);
    const F left = reach_m2 - outside_m * outside_m;
    weight.of[j] = left > 0.0f ? UpToOne(2.0f * left / reach_m2) : F{};
    inside.of[j] = left > 0.0f ? UpToOne(depth_m * in.inside_per_m) : F{};
  }
  StoreRow(near->weights, weight);
  Row left_out;
  for (int j = 0; j < kParts; ++j) {
    const F share = SharesNear(depth.of[j], in.unrefined) * (1.0f - weight.of[j]);
    left_out.of[j] = area.of[j] > 0.0f ? share : F{};
  }
  float sums[4];
  SumRows(weight.of, inside.of, left_out.of, left_out.of, sums);
  near->weight = sums[0];
  near->inside = sums[1];
  near->unrefined = sums[2];
}

void WeighSamples(const WeighInput& in, std::uint32_t begin, std::uint32_t end, NearBlock* near) {
  for (std::uint32_t i = begin; i < end; ++i) {
    const std::uint32_t block = in.near_blocks[i];
    WeighBlock(in, in.points[block], in.near_depths[in.near_slots[i]], in.spheres[block / kBlock].r[block % kBlock],
               &near[i - begin]);
  }
}

template <class T>
inline void UnpackRow(const T* steps, float step, float from, float* to) {
  for (std::uint32_t k = 0; k < kBlock; k += kLanes) StoreF(to + k, from + step * FromSteps(steps + k));
}
inline void UnpackPlaces(const FineSource& from, PointBlock* points) {
  const FineBlock& fine = *from.fine;
  const PointBlock& block = *from.block;
  UnpackRow(fine.x, fine.place_step_m, block.x[from.lane], points->x);
  UnpackRow(fine.y, fine.place_step_m, block.y[from.lane], points->y);
  UnpackRow(fine.z, fine.place_step_m, block.z[from.lane], points->z);
  UnpackRow(fine.share, block.area_m2[from.lane] * from.weight / kShares, 0.0f, points->area_m2);
}
inline void UnpackNormals(const FineSource& from, PointBlock* points) {
  const FineBlock& fine = *from.fine;
  const PointBlock& block = *from.block;
  UnpackRow(fine.nx, fine.normal_step, block.nx[from.lane], points->nx);
  UnpackRow(fine.ny, fine.normal_step, block.ny[from.lane], points->ny);
  UnpackRow(fine.nz, fine.normal_step, block.nz[from.lane], points->nz);
}

// Estimate of the quadrature error of sixteen points at the rim of a contact [voxels m^2]: the share of surface of a
// point at the rim is inside in part. The depth d has the standard deviation sigma over the patch and a quarter of it
// over a share; uniform over d +- h with h = sqrt(3) sigma / 4, its positive part has the mean (d + h)^2 / 4 h, which
// is
//
//   (h - |d|)^2 / 4 h   more than max(d, 0),  |d| < h.
inline float RimVolume_m2(const Row& depth, const Row& area, float sum) {
  Row squares;
  for (int j = 0; j < kParts; ++j) squares.of[j] = depth.of[j] * depth.of[j];
  float sums[4];
  SumRows(squares.of, squares.of, squares.of, squares.of, sums);
  const float mean = sum / kBlock;
  const float variance = sums[0] / kBlock - mean * mean;
  if (!(variance > 1e-8f)) return 0.0f;
  const float h = 0.433f * __builtin_sqrtf(variance);
  Row missing_m2;
  for (int j = 0; j < kParts; ++j) {
    const F part = h - (depth.of[j] < 0.0f ? -depth.of[j] : depth.of[j]);
    missing_m2.of[j] = (part > 0.0f ? part * part : F{}) * area.of[j];
  }
  SumRows(missing_m2.of, missing_m2.of, missing_m2.of, missing_m2.of, sums);
  return sums[0] / (4.0f * h);
}

// Of equally deep ones the one that FindDeepest (block_sums.hpp) takes.
inline std::uint32_t DeepestLane(const Row& depth, float most) {
  unsigned lanes = 0;
  for (int j = 0; j < kParts; ++j) lanes |= Bits(depth.of[j] == most) << j * kLanes;
  for (const unsigned of : {0x1111U, 0x4444U, 0x2222U}) {
    if ((lanes & of) != 0) return static_cast<std::uint32_t>(__builtin_ctz(lanes & of));
  }
  return static_cast<std::uint32_t>(__builtin_ctz(lanes));
}

// The penalty integral over the points (depths d, areas A as quadrature weights, positive parts):
//   volume = sum A d,  square = sum A d^2,  force = sum A d n,  moment = sum p x A d n.
inline void SumFinePoints(const PointBlock& points, const Row& depth, float m_per_voxel, FineSums* sums) {
  Row volume;
  Row square;
  Row force[3];
  Row moment[3];
  for (int j = 0; j < kParts; ++j) {
    const int at = j * kLanes;
    const F depth_m = (depth.of[j] > 0.0f ? depth.of[j] : F{}) * m_per_voxel;
    volume.of[j] = LoadF(points.area_m2 + at) * depth_m;
    square.of[j] = volume.of[j] * depth_m;
    const F p[3] = {LoadF(points.x + at), LoadF(points.y + at), LoadF(points.z + at)};
    const F f[3] = {volume.of[j] * LoadF(points.nx + at), volume.of[j] * LoadF(points.ny + at),
                    volume.of[j] * LoadF(points.nz + at)};
    for (int i = 0; i < 3; ++i) {
      force[i].of[j] = f[i];
      moment[i].of[j] = p[(i + 1) % 3] * f[(i + 2) % 3] - p[(i + 2) % 3] * f[(i + 1) % 3];
    }
  }
  float of[8];
  SumRows(force[0].of, force[1].of, force[2].of, volume.of, of);
  SumRows(moment[0].of, moment[1].of, moment[2].of, square.of, of + 4);
  *sums = {{of[0], of[1], of[2]}, {of[4], of[5], of[6]}, of[3], of[7]};
}

inline void LookAtFinePoints(const FineSource& from, PointBlock* at, const float* depths, const RefineInput& refine,
                             FinePoints* out) {
  const PointBlock& points = *at;
  const Row depth = LoadRow(depths);
  out->depth = MostOf(depth);
  const std::uint32_t k = DeepestLane(depth, out->depth);
  out->p[0] = points.x[k];
  out->p[1] = points.y[k];
  out->p[2] = points.z[k];
  out->num_near = out->near_m2 = out->volume_m2 = out->rim_m2 = 0.0f;
  out->sums = {};
  if (!(out->depth > -refine.near.outside)) return;
  const Row area = LoadRow(points.area_m2);
  Row share;
  Row share_m2;
  Row volume_m2;
  for (int j = 0; j < kParts; ++j) {
    share.of[j] = area.of[j] > 0.0f ? SharesNear(depth.of[j], refine.near) : F{};
    share_m2.of[j] = share.of[j] * area.of[j];
    volume_m2.of[j] = (depth.of[j] > 0.0f ? depth.of[j] : F{}) * area.of[j];
  }
  float sums[4];
  SumRows(share.of, share_m2.of, volume_m2.of, depth.of, sums);
  out->num_near = sums[0];
  out->near_m2 = sums[1];
  out->volume_m2 = sums[2];
  if (!(out->depth > 0.0f)) return;
  // h is at most 0.22 of the range of the depths, so that there is no rim where all are deeper.
  const float least = LeastOf(depth);
  if (out->volume_m2 > 0.0f && !(least > 0.25f * (out->depth - least))) {
    out->rim_m2 = RimVolume_m2(depth, area, sums[3]);
  }
  UnpackNormals(from, at);
  SumFinePoints(points, depth, refine.m_per_voxel, &out->sums);
}

// In batches that stay in the nearest cache.
void RefineSamples(const WalkInput& field, const RefineInput& refine, FinePoints* out) {
  PointBlock points[kBatch];
  SphereBlock spheres[kBatch / kBlock];
  alignas(64) std::uint32_t ids[2 * kBatch];
  alignas(64) float depths[kBatch * kBlock];
  WalkInput in = field;
  in.points = points;
  in.spheres = spheres;
  for (std::uint32_t k = 0; k < 2 * kBatch; ++k) ids[k] = k < kBatch ? k : 0;
  Windows windows;
  for (std::uint32_t begin = 0; begin < refine.count; begin += kBatch) {
    const std::uint32_t left = refine.count - begin;
    const std::uint32_t count = left < kBatch ? left : kBatch;
    for (std::uint32_t i = 0; i < kBatch; ++i) {
      const FineSource& from = refine.sources[begin + (i < count ? i : 0)];
      SphereBlock& sphere = spheres[i / kBlock];
      sphere.x[i % kBlock] = from.block->x[from.lane];
      sphere.y[i % kBlock] = from.block->y[from.lane];
      sphere.z[i % kBlock] = from.block->z[from.lane];
      sphere.r[i % kBlock] = from.fine->reach_m;
      if (i < count) UnpackPlaces(from, &points[i]);
    }
    FindWindows(in, ids, count, &windows);
    FindDepths(in, ids, count, windows, depths);
    for (std::uint32_t i = 0; i < count; ++i) {
      float* const of = depths + i * kBlock;
      for (std::uint32_t k = 0; k < kBlock; k += kLanes) {
        StoreF(of + k, MeanDepth(in, LoadF(of + k), LoadF(points[i].area_m2 + k), windows.curvature[i]));
      }
      LookAtFinePoints(refine.sources[begin + i], &points[i], of, refine, &out[begin + i]);
    }
  }
}

// Of blocks of points without a tree: block i in sphere i.
void FindDepthsOf(const WalkInput& in, std::uint32_t num_blocks, float (*depths)[kBlock]) {
  alignas(64) std::uint32_t ids[2 * kBatch];
  Windows windows;
  for (std::uint32_t begin = 0; begin < num_blocks; begin += kBatch) {
    const std::uint32_t left = num_blocks - begin;
    const std::uint32_t count = left < kBatch ? left : kBatch;
    for (std::uint32_t k = 0; k < 2 * kBatch; ++k) ids[k] = begin + (k < left ? k : 0);
    FindWindows(in, ids, count, &windows);
    FindDepths(in, ids, count, windows, depths[begin]);
    for (std::uint32_t i = 0; i < count; ++i) {
      float* const of = depths[begin + i];
      for (std::uint32_t k = 0; k < kBlock; k += kLanes) {
        StoreF(of + k, MeanDepth(in, LoadF(of + k), LoadF(in.points[begin + i].area_m2 + k), windows.curvature[i]));
      }
    }
  }
}
