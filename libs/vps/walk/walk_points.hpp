// The point tests of the walk kernels; included by walk_lanes.hpp.
//
// Blocks go through in batches. First every block: where its points lie in two by two by two bricks, the offsets of
// those eight are one register, and a lane's word is one lookup there and one gather. Lanes whose cell is no plane are
// put aside and done in full registers. Then, with all depths known, the sums.

constexpr std::uint32_t kBatch = 64;
constexpr std::uint32_t kNoWindow = 0xffffffffU;
// Added to a float below 2^21, leaves the nearest integer in the low bits of its word.
constexpr float kRounder = 12582912.0f;

// Per block: the first of its eight bricks and the transform's translation to that brick's corner, less half a voxel so
// that a point rounds to its cell.
struct Windows {
  alignas(64) std::uint32_t slot[kBatch];
  alignas(64) float t[3][kBatch];
};

inline void FindWindows(const WalkInput& in, const std::uint32_t* blocks, std::uint32_t count, Windows* out) {
  constexpr float kPad = 0.1f;  // of a point from the window's faces
  const auto* const spheres = reinterpret_cast<const std::uint32_t*>(in.spheres);
  constexpr std::uint32_t kSphereWords = sizeof(SphereBlock) / 4;
  const std::int32_t bricks[3] = {in.nx >> 3, in.ny >> 3, in.nz >> 3};
  for (std::uint32_t i = 0; i < count; i += kLanes) {
    const U block = LoadU(blocks + i);
    const U at = (block >> 4) * kSphereWords + (block & 15U);
    const Vec3 c =
        ToVoxels(in, (F)Gather(spheres, at), (F)Gather(spheres + kBlock, at), (F)Gather(spheres + 2 * kBlock, at));
    const F reach = (F)Gather(spheres + 3 * kBlock, at) * in.voxels_per_m + kPad;
    I fits = (I)(block != in.partial_block);
    I corner[3];
    const F centre[3] = {c.x, c.y, c.z};
    for (int a = 0; a < 3; ++a) {
      const F low = centre[a] - reach;
      const I limited = I{} + (bricks[a] - 2);
      const I b = ToI(Max(Min(low, Fill(static_cast<float>(8 * bricks[a]))), F{})) >> 3;
      corner[a] = b < limited ? b : limited;
      fits &= (low >= 0.0f) & (centre[a] + reach <= ToF(corner[a] * 8 + 16));
      StoreF(&out->t[a][i], in.t[a] - (ToF(corner[a] * 8) + 0.5f));
    }
    const I slot = (corner[2] * bricks[1] + corner[1]) * bricks[0] + corner[0];
    StoreU(&out->slot[i], (U)(fits ? slot : I{} - 1));
  }
}

// Lanes put aside: words of crease cells with the place in the cell; places that only SampleAnywhere knows; `to` is the
// index of the depth.
struct Aside {
  static constexpr std::uint32_t kMost = kBatch * kBlock + kBlock;
  alignas(64) std::uint32_t word[kMost];
  alignas(64) float x[kMost], y[kMost], z[kMost];
  alignas(64) std::uint32_t to[kMost];
  std::uint32_t count;
};

inline void PutAside(const Vec3& p, U to, unsigned lanes, Aside* aside) {
  const std::uint32_t n = aside->count;
  Compress(reinterpret_cast<std::uint32_t*>(aside->x + n), (U)p.x, lanes);
  Compress(reinterpret_cast<std::uint32_t*>(aside->y + n), (U)p.y, lanes);
  Compress(reinterpret_cast<std::uint32_t*>(aside->z + n), (U)p.z, lanes);
  Compress(aside->to + n, to, lanes);
  aside->count = n + static_cast<std::uint32_t>(__builtin_popcount(lanes));
}

// The lanes behind the last repeat it.
inline void FillUp(Aside* aside) {
  const std::uint32_t n = aside->count;
  for (std::uint32_t k = n; k % kLanes != 0; ++k) {
    aside->word[k] = aside->word[n - 1];
    aside->x[k] = aside->x[n - 1];
    aside->y[k] = aside->y[n - 1];
    aside->z[k] = aside->z[n - 1];
    aside->to[k] = aside->to[n - 1];
  }
}

inline void StoreDepths(F d, const std::uint32_t* to, float* depths) {
  float buffer[kLanes];
  StoreF(buffer, -d);
  for (int k = 0; k < kLanes; ++k) depths[to[k]] = buffer[k];
}

inline U LaneNumbers() {
  U v;
  for (int k = 0; k < kLanes; ++k) v[k] = static_cast<std::uint32_t>(k);
  return v;
}

// Depths of a batch, and the least distance found, less what the model may be off.
inline float FindDepths(const WalkInput& in, const std::uint32_t* blocks, std::uint32_t count, float* depths) {
  Windows windows;
  FindWindows(in, blocks, count, &windows);
  Aside creases;
  Aside anywhere;
  creases.count = anywhere.count = 0;
  const auto stride_y = static_cast<std::size_t>(in.nx >> 3);
  const std::size_t stride_z = stride_y * static_cast<std::size_t>(in.ny >> 3);
  F room = Fill(1e30f);
  for (std::uint32_t i = 0; i < count; ++i) {
    const PointBlock& block = in.points[blocks[i]];
    if (windows.slot[i] == kNoWindow) {
      for (int j = 0; j < kParts; ++j) {
        const int at = j * kLanes;
        const Vec3 p = ToVoxels(in, LoadF(block.x + at), LoadF(block.y + at), LoadF(block.z + at));
        F slack;
        const F d = SampleAnywhere<false>(in, p, &slack);
        room = Min(room, d - slack);
        StoreF(depths + i * kBlock + at, -d);
      }
      continue;
    }
    const Octet octet = LoadOctet(in.bricks + windows.slot[i], stride_y, stride_z);
    const F tx = Fill(windows.t[0][i]);
    const F ty = Fill(windows.t[1][i]);
    const F tz = Fill(windows.t[2][i]);
    for (int j = 0; j < kParts; ++j) {
      const int at = j * kLanes;
      const F x = LoadF(block.x + at);
      const F y = LoadF(block.y + at);
      const F z = LoadF(block.z + at);
      const Vec3 p{Fma(Fill(in.m[0][0]), x, Fma(Fill(in.m[0][1]), y, Fma(Fill(in.m[0][2]), z, tx))),
                   Fma(Fill(in.m[1][0]), x, Fma(Fill(in.m[1][1]), y, Fma(Fill(in.m[1][2]), z, ty))),
                   Fma(Fill(in.m[2][0]), x, Fma(Fill(in.m[2][1]), y, Fma(Fill(in.m[2][2]), z, tz)))};
      const F rx = p.x + kRounder;
      const F ry = p.y + kRounder;
      const F rz = p.z + kRounder;
      const F cy = ry - kRounder;
      const F cz = rz - kRounder;
      const Vec3 e{p.x - (rx - kRounder), p.y - cy, p.z - cz};
      const U brick = ((U)rx >> 3 & 1U) | ((U)ry >> 2 & 2U) | ((U)rz >> 1 & 4U);
      // x + 8 y + 64 z of the cell within the window: what of it belongs to the brick the octet has taken off.
      const U cell = (U)Fma(cz, Fill(64.0f), Fma(cy, Fill(8.0f), rx));
      const U word = Gather(in.words, LookUp(octet, brick) + cell);
      const F d = PlaneAt(word, e);
      StoreF(depths + i * kBlock + at, -d);
      const I is_other = (I)(word << 25) == static_cast<std::int32_t>(kOtherKind << 25);
      const unsigned others = Bits(is_other);
      room = Min(room, is_other ? Fill(1e30f) : d - kModelSlack);
      if (others == 0) continue;
      const U to = LaneNumbers() + (i * kBlock + static_cast<std::uint32_t>(at));
      const unsigned coarse = Bits((I)(word == kCoarseWord));
      if (coarse != 0) {
        // Back to the whole grid.
        const Vec3 whole{p.x + (in.t[0] - tx), p.y + (in.t[1] - ty), p.z + (in.t[2] - tz)};
        PutAside(whole, to, coarse, &anywhere);
      }
      if (coarse != others) {
        Compress(creases.word + creases.count, word, others & ~coarse);
        PutAside(e, to, others & ~coarse, &creases);
      }
    }
  }
  if (creases.count > 0) FillUp(&creases);
  for (std::uint32_t k = 0; k < creases.count; k += kLanes) {
    const Vec3 e{LoadF(creases.x + k), LoadF(creases.y + k), LoadF(creases.z + k)};
    const F d = CreaseAt(in, LoadU(creases.word + k) >> 7, e);
    room = Min(room, d - kModelSlack);
    StoreDepths(d, creases.to + k, depths);
  }
  if (anywhere.count > 0) FillUp(&anywhere);
  for (std::uint32_t k = 0; k < anywhere.count; k += kLanes) {
    const Vec3 p{LoadF(anywhere.x + k), LoadF(anywhere.y + k), LoadF(anywhere.z + k)};
    F slack;
    const F d = SampleAnywhere<false>(in, p, &slack);
    room = Min(room, d - slack);
    StoreDepths(d, anywhere.to + k, depths);
  }
  return Least(room);
}

// Sums in float of the blocks whose numbers differ only in the last five bits, then added to the doubles: what a sum
// gives does not depend on the blocks without contact that were tested besides.
constexpr int kSharedBits = 5;
struct Partial {
  F of[WalkSums::kNumSums][kParts];
  std::uint32_t group;
  bool is_empty;
};

inline void Flush(Partial* partial, WalkSums* sums) {
  if (partial->is_empty) return;
  for (int s = 0; s < WalkSums::kNumSums; ++s) {
    alignas(64) float buffer[kBlock];
    for (int j = 0; j < kParts; ++j) {
      StoreF(buffer + j * kLanes, partial->of[s][j]);
      partial->of[s][j] = F{};
    }
    for (std::uint32_t k = 0; k < kBlock; ++k) sums->of[s][k] += static_cast<double>(buffer[k]);
  }
  partial->is_empty = true;
}

inline void AddBlock(const PointBlock& block, const F* depth, Partial* partial) {
  for (int j = 0; j < kParts; ++j) {
    const int at = j * kLanes;
    const F area = depth[j] > 0.0f ? LoadF(block.area_m2 + at) : F{};
    const F volume = area * depth[j];
    const F fx = volume * LoadF(block.nx + at);
    const F fy = volume * LoadF(block.ny + at);
    const F fz = volume * LoadF(block.nz + at);
    // Lanes without area may be the fillers far away: 0 times their place is 0.
    const F x = LoadF(block.x + at);
    const F y = LoadF(block.y + at);
    const F z = LoadF(block.z + at);
    partial->of[WalkSums::kFx][j] += fx;
    partial->of[WalkSums::kFy][j] += fy;
    partial->of[WalkSums::kFz][j] += fz;
    partial->of[WalkSums::kMx][j] += Fma(y, fz, -(z * fy));
    partial->of[WalkSums::kMy][j] += Fma(z, fx, -(x * fz));
    partial->of[WalkSums::kMz][j] += Fma(x, fy, -(y * fx));
    partial->of[WalkSums::kVolume][j] += volume;
    partial->of[WalkSums::kSquare][j] = Fma(volume, depth[j], partial->of[WalkSums::kSquare][j]);
  }
  partial->is_empty = false;
}

void Evaluate(const WalkInput& in, const WalkChunk& chunk, WalkSums* sums) {
  __builtin_memset(sums->of, 0, sizeof sums->of);
  sums->num_near = sums->num_colliding = sums->num_near_blocks = 0;
  Partial partial;
  __builtin_memset(&partial, 0, sizeof partial);
  partial.is_empty = true;
  F deepest[kParts];
  I deepest_block[kParts];
  for (int j = 0; j < kParts; ++j) {
    deepest[j] = Fill(-1e30f);
    deepest_block[j] = I{};
  }
  alignas(64) std::uint32_t ids[kBatch];
  alignas(64) float depths[kBatch * kBlock];
  float room = 1e30f;
  for (std::uint32_t begin = 0; begin < chunk.num_blocks; begin += kBatch) {
    const std::uint32_t count = chunk.num_blocks - begin < kBatch ? chunk.num_blocks - begin : kBatch;
    __builtin_memcpy(ids, chunk.blocks + begin, count * sizeof ids[0]);
    for (std::uint32_t k = count; k % kLanes != 0; ++k) ids[k] = ids[0];
    const float found = FindDepths(in, ids, count, depths);
    room = found < room ? found : room;
    for (std::uint32_t i = 0; i < count; ++i) {
      F depth[kParts];
      unsigned near = 0;
      unsigned colliding = 0;
      for (int j = 0; j < kParts; ++j) {
        depth[j] = LoadF(depths + i * kBlock + j * kLanes);
        near |= Bits(-depth[j] <= in.margin) << j * kLanes;
        colliding |= Bits(depth[j] > 0.0f) << j * kLanes;
      }
      if (near == 0) continue;
      float* const near_depths = chunk.near_depths[sums->num_near_blocks];
      chunk.near_blocks[sums->num_near_blocks++] = ids[i];
      sums->num_near += static_cast<std::uint32_t>(__builtin_popcount(near));
      for (int j = 0; j < kParts; ++j) {
        StoreF(near_depths + j * kLanes, depth[j]);
        const I is_deeper = depth[j] > deepest[j];
        deepest[j] = is_deeper ? depth[j] : deepest[j];
        deepest_block[j] = is_deeper ? I{} + static_cast<std::int32_t>(ids[i]) : deepest_block[j];
      }
      if (colliding == 0) continue;
      sums->num_colliding += static_cast<std::uint32_t>(__builtin_popcount(colliding));
      if (ids[i] >> kSharedBits != partial.group) {
        Flush(&partial, sums);
        partial.group = ids[i] >> kSharedBits;
      }
      AddBlock(in.points[ids[i]], depth, &partial);
    }
  }
  Flush(&partial, sums);
  for (int j = 0; j < kParts; ++j) {
    StoreF(sums->depth + j * kLanes, deepest[j]);
    StoreU(sums->depth_block + j * kLanes, (U)deepest_block[j]);
  }
  sums->room = room;
}
