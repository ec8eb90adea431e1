// The point tests of the walk kernels; included by walk_lanes.hpp.

// Mean depth over a point's patch, of a positive depth d at its centroid (decision 10). To second order the distance of
// G has the mean  d_G + tr(H C) / 2  over the patch: H are its second derivatives with the trace k1 + k2 (the principal
// curvatures of the brick that the block's middle is in, 1/voxel), C the patch's second moments, about area / 12 in
// both directions of the surface, so
//
//   mean depth = d - area (k1 + k2) / 24   [voxels],
//
// changed by at most half of d, so that the force is continuous at d = 0.
inline F MeanDepth(const WalkInput& in, std::uint32_t id, F depth, F area) {
  const SphereBlock& s = in.spheres[id / kBlock];
  const std::uint32_t k = id % kBlock;
  const Vec3 middle = ToVoxels(in, Fill(s.x[k]), Fill(s.y[k]), Fill(s.z[k]));
  const U brick = FindVoxel(in, ClampToGrid(in, middle)).brick;
  const U both = Gather(in.curvatures, brick >> 1);
  const F curvature = ToF((I)((brick & 1U) != 0 ? both : both << 16) >> 16) * (kCurvatureStep / 24.0f);
  const F less = area * (in.voxels_per_m * in.voxels_per_m * curvature);
  const F most = depth * 0.5f;
  return depth > 0.0f ? depth - Max(Min(less, most), -most) : depth;
}

typedef F Sums[WalkChunk::kNumSums][kParts];

inline void AddDepth(const PointBlock& block, int j, F depth, Sums* sums) {
  const int at = j * kLanes;
  const F area = depth > 0.0f ? LoadF(block.area_m2 + at) : F{};
  const F volume = area * depth;
  const Vec3 f = Times({LoadF(block.nx + at), LoadF(block.ny + at), LoadF(block.nz + at)}, volume);
  // Lanes without area may be the fillers far away: 0 times their place is 0.
  const Vec3 m = Cross({LoadF(block.x + at), LoadF(block.y + at), LoadF(block.z + at)}, f);
  (*sums)[WalkChunk::kFx][j] += f.x;
  (*sums)[WalkChunk::kFy][j] += f.y;
  (*sums)[WalkChunk::kFz][j] += f.z;
  (*sums)[WalkChunk::kMx][j] += m.x;
  (*sums)[WalkChunk::kMy][j] += m.y;
  (*sums)[WalkChunk::kMz][j] += m.z;
  (*sums)[WalkChunk::kVolume][j] += volume;
  (*sums)[WalkChunk::kSquare][j] = Fma(volume, depth, (*sums)[WalkChunk::kSquare][j]);
}

// What the samples near the zero level miss: a sample counts max(d, 0), but the depth varies over its cell, and a cell
// that is cut by the zero level has more. With the depth d + s, s spread evenly over [-w / 2, w / 2], the mean exceeds
// max(d, 0) by
//
//   (w / 2 - |d|)^2 / (2 w)   while |d| < w / 2, else by 0.
//
// w = h sqrt(|g|^2 - (g . n)^2): how much a linear depth changes over a cell of side h; g is the field's gradient, the
// root its part along the surface. Where several of G's facets are near it is taken as 1, the most that is possible.
inline void AddMissed(const WalkInput& in, const PointBlock& block, int j, F depth, const FieldAt& field, Sums* sums) {
  const int at = j * kLanes;
  const F area = LoadF(block.area_m2 + at);
  const F h2 = area * (in.voxels_per_m * in.voxels_per_m);
  if (LessBits(depth * depth * 4.0f, h2) == 0) return;
  const Vec3& g = field.gradient;
  const Vec3 n = Turn(in, LoadF(block.nx + at), LoadF(block.ny + at), LoadF(block.nz + at));
  const F along = Dot(g, n) * in.m_per_voxel;
  const F slope2 = Min(Max(Dot(g, g) - along * along, F{}), Fill(1.0f));
  const F w = Sqrt((field.is_plane ? slope2 : Fill(1.0f)) * h2);
  const F within = Max(w * 0.5f - Abs(depth), F{});
  const F missed = within > 0.0f ? area * (within * within / (w * 2.0f)) : F{};
  (*sums)[WalkChunk::kMissed][j] += missed;
  (*sums)[WalkChunk::kMissedSquared][j] = Fma(missed, missed, (*sums)[WalkChunk::kMissedSquared][j]);
}

constexpr std::uint32_t kBatch = 16;  // blocks; not derived

// The points of some blocks in G's voxels, and the words of the field there. All are read before any is looked at: so
// the many misses of the caches overlap, instead of waiting behind a branch that was guessed wrong. Lane by lane: that
// takes the processors less time than a gather (decision 14).
struct Places {
  alignas(64) float x[kBatch * kBlock], y[kBatch * kBlock], z[kBatch * kBlock];
  alignas(64) std::uint32_t brick[kBatch * kBlock], word[kBatch * kBlock];
};
inline void FindPlaces(const WalkInput in, const std::uint32_t* blocks, std::uint32_t count, Places* to) {
  for (std::uint32_t i = 0; i < count * kBlock; i += kLanes) {
    const PointBlock& block = in.points[blocks[i / kBlock]];
    const std::uint32_t at = i % kBlock;
    const Vec3 p = ToVoxels(in, LoadF(block.x + at), LoadF(block.y + at), LoadF(block.z + at));
    const Voxel voxel = FindVoxel(in, ClampToGrid(in, p));
    Store(p, to->x + i, to->y + i, to->z + i);
    StoreU(to->brick + i, voxel.brick);
    StoreU(to->word + i, voxel.in_brick);
  }
  for (std::uint32_t i = 0; i < count * kBlock; ++i) {
    to->word[i] = in.words[in.bricks[to->brick[i]] + to->word[i]];
    __asm__ volatile("");  // or compilers take registers apart for it, which takes twice as long
  }
}

void Evaluate(const WalkInput& input, WalkChunk* chunk) {
  const WalkInput in = input;  // which no store can change
  Sums sums;
  F deepest[kParts];
  I deepest_block[kParts];
  for (int j = 0; j < kParts; ++j) {
    for (auto& sum : sums) sum[j] = F{};
    deepest[j] = Fill(-1e30f);
    deepest_block[j] = I{};
  }
  F least = Fill(1e30f);
  chunk->num_near = chunk->num_colliding = chunk->num_near_blocks = 0;
  Places places;
  for (std::uint32_t i = 0; i < chunk->num_blocks; ++i) {
    if (i % kBatch == 0) {
      const std::uint32_t left = chunk->num_blocks - i;
      FindPlaces(in, chunk->blocks + i, left < kBatch ? left : kBatch, &places);
    }
    const std::uint32_t first = i % kBatch * kBlock;
    const std::uint32_t id = chunk->blocks[i];
    const PointBlock& block = in.points[id];
    FieldAt field[kParts];
    unsigned near = 0;
    unsigned colliding = 0;
    for (int j = 0; j < kParts; ++j) {
      const std::uint32_t at = first + static_cast<std::uint32_t>(j * kLanes);
      const Vec3 p{LoadF(places.x + at), LoadF(places.y + at), LoadF(places.z + at)};
      field[j] = SampleWithGradient(in, p, LoadU(places.word + at));
      least = Min(least, field[j].distance);
      near |= Bits((I)(field[j].distance <= in.margin)) << j * kLanes;
      colliding |= LessBits(field[j].distance, F{}) << j * kLanes;
    }
    if (near == 0) continue;
    float* const depths = chunk->near_depths[chunk->num_near_blocks];
    chunk->near_blocks[chunk->num_near_blocks++] = id;
    chunk->num_near += static_cast<std::uint32_t>(__builtin_popcount(near));
    chunk->num_colliding += static_cast<std::uint32_t>(__builtin_popcount(colliding));
    for (int j = 0; j < kParts; ++j) {
      F depth = -field[j].distance;
      if (colliding != 0) {
        depth = MeanDepth(in, id, depth, LoadF(block.area_m2 + j * kLanes));
        AddDepth(block, j, depth, &sums);
      }
      StoreF(depths + j * kLanes, depth);
      const I is_deeper = depth > deepest[j];
      deepest[j] = is_deeper ? depth : deepest[j];
      deepest_block[j] = is_deeper ? I{} + static_cast<std::int32_t>(id) : deepest_block[j];
      AddMissed(in, block, j, depth, field[j], &sums);
    }
  }
  for (int j = 0; j < kParts; ++j) {
    for (int s = 0; s < WalkChunk::kNumSums; ++s) StoreF(chunk->sums[s] + j * kLanes, sums[s][j]);
    StoreF(chunk->depth + j * kLanes, deepest[j]);
    StoreU(chunk->depth_block + j * kLanes, (U)deepest_block[j]);
  }
  chunk->free_distance = Least(least);
}
