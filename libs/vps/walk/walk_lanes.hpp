// Body of the walk kernels, included by one file per instruction set, which defines before, inside namespace vps and
// an anonymous namespace: kLanes (4, 8 or 16), the vector types F, I, U of so many float, int32, uint32, and
//   U Gather(const std::uint32_t* base, U index);   F Sqrt(F);   unsigned Bits(I mask);
// Vectors are GCC's: arithmetic and ?: work lane by lane, a comparison gives 0 or -1 per lane. The operations are those
// of SampleField, in the same order.

constexpr int kChunks = kBlock / kLanes;

inline F LoadF(const float* p) {
  F v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}
inline void StoreF(float* p, F v) {
  __builtin_memcpy(p, &v, sizeof v);
}
inline F Fill(float a) {
  return F{} + a;
}
inline F ToF(I v) {
  return __builtin_convertvector(v, F);
}
inline I ToI(F v) {
  return __builtin_convertvector(v, I);
}
inline F Min(F a, F b) {
  return a < b ? a : b;
}
inline F Max(F a, F b) {
  return a > b ? a : b;
}
inline F Abs(F a) {
  return (F)((I)a & 0x7fffffff);
}

struct Vec3 {
  F x, y, z;
};

// Octahedral codes in [-1, 1] to a unit vector; returns its product with e.
inline F DotOctahedral(F x, F y, const Vec3& e) {
  const F z = (1.0f - Abs(x)) - Abs(y);
  const F fold = Max(-z, F{});
  x = x >= 0.0f ? x - fold : x + fold;
  y = y >= 0.0f ? y - fold : y + fold;
  const F u = (x * x + y * y) + z * z;
  const F scale = kRootC0 + u * (kRootC1 + u * (kRootC2 + u * (kRootC3 + u * kRootC4)));
  return ((x * scale) * e.x + (y * scale) * e.y) + (z * scale) * e.z;
}

inline F WordDistance(U word) {
  return ToF((I)(word << 20) >> 20) * (1.0f / kDistanceSteps);
}
inline F PlaneAt(U word, const Vec3& e) {
  const F x = ToF((I)(word >> 12 & 0x1ffU)) * (1.0f / kOctahedralSteps) - 1.0f;
  const F y = ToF((I)(word >> 21 & 0x1ffU)) * (1.0f / kOctahedralSteps) - 1.0f;
  return WordDistance(word) + DotOctahedral(x, y, e);
}

// Field at points in voxel units. kBound: lower bound of the distance by way of the cell's centre (spheres); else the
// model's distance (points), with `slack` how far that may be off.
template <bool kBound>
inline F Sample(const WalkInput& in, const Vec3& p, F* slack) {
  const float last_x = static_cast<float>(in.nx) - 0.5f;
  const float last_y = static_cast<float>(in.ny) - 0.5f;
  const float last_z = static_cast<float>(in.nz) - 0.5f;
  const Vec3 q{Min(Max(p.x, F{}), Fill(last_x)), Min(Max(p.y, F{}), Fill(last_y)), Min(Max(p.z, F{}), Fill(last_z))};
  const I cx = ToI(q.x);
  const I cy = ToI(q.y);
  const I cz = ToI(q.z);
  const std::int32_t bricks_x = in.nx >> 3;
  const std::int32_t bricks_y = in.ny >> 3;
  const U brick = Gather(in.bricks, (U)(((cz >> 3) * bricks_y + (cy >> 3)) * bricks_x + (cx >> 3)));
  const U word = Gather(in.words, brick + (U)((cz & 7) << 6 | (cy & 7) << 3 | (cx & 7)));
  const Vec3 e{q.x - ToF(cx) - 0.5f, q.y - ToF(cy) - 0.5f, q.z - ToF(cz) - 0.5f};
  const U kind = word >> 30;
  const I is_crease = (I)(kind == static_cast<std::uint32_t>(CellKind::kCrease));
  const I is_coarse = (I)(kind == static_cast<std::uint32_t>(CellKind::kCoarse));
  F d = kBound ? WordDistance(word) - Sqrt((e.x * e.x + e.y * e.y) + e.z * e.z) : PlaneAt(word, e);
  if (!kBound) *slack = Fill(kModelSlack);
  if (Bits(is_crease) != 0) {
    const U record = (U)(is_crease ? (I)(word & 0x3fffffffU) : I{}) * kPlanesPerCrease;
    const U first = Gather(in.creases, record);
    const F side = (I)(first << 1) < 0 ? Fill(-1.0f) : Fill(1.0f);
    const I is_nested = (I)first < 0;
    const F u0 = side * PlaneAt(first, e);
    const F u1 = side * PlaneAt(Gather(in.creases, record + 1), e);
    const F u2 = side * PlaneAt(Gather(in.creases, record + 2), e);
    const F u3 = side * PlaneAt(Gather(in.creases, record + 3), e);
    const F a = is_nested ? Min(u0, u1) : Max(u0, u1);
    const F b = is_nested ? Min(u2, u3) : Max(u2, u3);
    d = is_crease ? side * Max(a, b) : d;
  }
  if (Bits(is_coarse) != 0) {
    const int shift = in.coarse_shift;
    const I x = cx >> shift;
    const I y = cy >> shift;
    const I z = cz >> shift;
    const float half = static_cast<float>(1 << shift) * 0.5f;
    const U at = (U)(is_coarse ? ((z * (in.ny >> shift) + y) * (in.nx >> shift) + x) * 2 : I{});
    const std::uint32_t* const cells = reinterpret_cast<const std::uint32_t*>(in.coarse);
    const Vec3 ec{q.x - ToF(x << shift) - half, q.y - ToF(y << shift) - half, q.z - ToF(z << shift) - half};
    const F centre = (F)Gather(cells, at);
    if (kBound) {
      d = is_coarse ? centre - Sqrt((ec.x * ec.x + ec.y * ec.y) + ec.z * ec.z) : d;
    } else {
      const U code = Gather(cells, at + 1);
      const F ox = ToF((I)(code & 0xffffU)) * (1.0f / kCoarseOctahedralSteps) - 1.0f;
      const F oy = ToF((I)(code >> 16)) * (1.0f / kCoarseOctahedralSteps) - 1.0f;
      d = is_coarse ? centre + DotOctahedral(ox, oy, ec) : d;
      *slack = is_coarse ? Fill(kModelSlack * 2.0f * half) : *slack;
    }
  }
  const F outside = Max(Max(Abs(p.x - q.x), Abs(p.y - q.y)), Abs(p.z - q.z));
  return outside > 0.0f ? Max(d, outside) : d;
}

inline Vec3 ToVoxels(const WalkInput& in, const float* px, const float* py, const float* pz) {
  const F x = LoadF(px);
  const F y = LoadF(py);
  const F z = LoadF(pz);
  return {in.m[0][0] * x + in.m[0][1] * y + in.m[0][2] * z + in.t[0],
          in.m[1][0] * x + in.m[1][1] * y + in.m[1][2] * z + in.t[1],
          in.m[2][0] * x + in.m[2][1] * y + in.m[2][2] * z + in.t[2]};
}

// Sums of some blocks in float, then added to the doubles.
struct Sums {
  F lane[WalkOutput::kNumSums][kChunks];
  std::uint32_t num_blocks;
};
constexpr std::uint32_t kBlocksPerFlush = 32;

inline void Flush(Sums* sums, WalkOutput* out) {
  float buffer[kBlock];
  for (int s = 0; s < WalkOutput::kNumSums; ++s) {
    for (int j = 0; j < kChunks; ++j) {
      StoreF(buffer + j * kLanes, sums->lane[s][j]);
      sums->lane[s][j] = F{};
    }
    for (std::uint32_t k = 0; k < kBlock; ++k) out->sums[s][k] += static_cast<double>(buffer[k]);
  }
  sums->num_blocks = 0;
}

inline void Walk(const WalkInput& in, const WalkScratch& scratch, WalkOutput* out) {
  for (int s = 0; s < WalkOutput::kNumSums; ++s) {
    for (std::uint32_t k = 0; k < kBlock; ++k) out->sums[s][k] = 0.0;
  }
  out->num_near = out->num_colliding = out->num_near_blocks = out->spheres_tested = out->points_tested = 0;

  // Level by level: the queue of one half fills the other.
  std::uint32_t* queue = scratch.queue;
  std::uint32_t* next = scratch.queue + scratch.queue_half;
  std::uint32_t size = 1;
  queue[0] = 0;
  F room = Fill(1e30f);
  const float limit = in.margin + kCullSlack;
  for (std::uint32_t level = in.num_levels; level-- > 0;) {
    const SphereBlock* const blocks = in.spheres + in.level_begin[level];
    std::uint32_t num_next = 0;
    for (std::uint32_t i = 0; i < size; ++i) {
      const SphereBlock& block = blocks[queue[i]];
      unsigned survivors = 0;
      for (int j = 0; j < kChunks; ++j) {
        const int at = j * kLanes;
        F unused;
        const F d = Sample<true>(in, ToVoxels(in, block.x + at, block.y + at, block.z + at), &unused);
        const F reach = d - LoadF(block.r + at) * in.voxels_per_m;
        const I is_near = reach <= limit;
        room = Min(room, is_near ? Fill(1e30f) : reach);
        survivors |= Bits(is_near) << at;
      }
      out->spheres_tested += kBlock;
      const std::uint32_t first = queue[i] * kBlock;
      while (survivors != 0) {
        next[num_next++] = first + static_cast<std::uint32_t>(__builtin_ctz(survivors));
        survivors &= survivors - 1;
      }
    }
    std::uint32_t* const swapped = queue;
    queue = next;
    next = swapped;
    size = num_next;
  }
  room -= kCullSlack;

  Sums sums;
  for (int s = 0; s < WalkOutput::kNumSums; ++s) {
    for (int j = 0; j < kChunks; ++j) sums.lane[s][j] = F{};
  }
  sums.num_blocks = 0;
  F deepest[kChunks];
  I deepest_block[kChunks];
  for (int j = 0; j < kChunks; ++j) {
    deepest[j] = Fill(-1e30f);
    deepest_block[j] = I{};
  }
  for (std::uint32_t i = 0; i < size; ++i) {
    const PointBlock& block = in.points[queue[i]];
    const auto id = static_cast<std::int32_t>(queue[i]);
    F depth[kChunks];
    unsigned near = 0;
    unsigned colliding = 0;
    for (int j = 0; j < kChunks; ++j) {
      const int at = j * kLanes;
      F slack;
      const F d = Sample<false>(in, ToVoxels(in, block.x + at, block.y + at, block.z + at), &slack);
      room = Min(room, d - slack);
      depth[j] = -d;
      near |= Bits(d <= in.margin) << at;
      colliding |= Bits(d < 0.0f) << at;
    }
    out->points_tested += kBlock;
    if (near == 0) continue;
    float* const depths = scratch.near_depths[out->num_near_blocks];
    scratch.near_blocks[out->num_near_blocks++] = queue[i];
    out->num_near += static_cast<std::uint32_t>(__builtin_popcount(near));
    for (int j = 0; j < kChunks; ++j) {
      StoreF(depths + j * kLanes, depth[j]);
      const I is_deeper = depth[j] > deepest[j];
      deepest[j] = is_deeper ? depth[j] : deepest[j];
      deepest_block[j] = is_deeper ? I{} + id : deepest_block[j];
    }
    if (colliding == 0) continue;
    out->num_colliding += static_cast<std::uint32_t>(__builtin_popcount(colliding));
    for (int j = 0; j < kChunks; ++j) {
      const int at = j * kLanes;
      const F area = depth[j] > 0.0f ? LoadF(block.area_m2 + at) : F{};
      const F volume = area * depth[j];
      const F fx = volume * LoadF(block.nx + at);
      const F fy = volume * LoadF(block.ny + at);
      const F fz = volume * LoadF(block.nz + at);
      const F x = LoadF(block.x + at);
      const F y = LoadF(block.y + at);
      const F z = LoadF(block.z + at);
      sums.lane[WalkOutput::kFx][j] += fx;
      sums.lane[WalkOutput::kFy][j] += fy;
      sums.lane[WalkOutput::kFz][j] += fz;
      // Lanes without area may be the fillers far away: 0 times their place is 0.
      sums.lane[WalkOutput::kMx][j] += y * fz - z * fy;
      sums.lane[WalkOutput::kMy][j] += z * fx - x * fz;
      sums.lane[WalkOutput::kMz][j] += x * fy - y * fx;
      sums.lane[WalkOutput::kVolume][j] += volume;
      sums.lane[WalkOutput::kSquare][j] += volume * depth[j];
    }
    if (++sums.num_blocks == kBlocksPerFlush) Flush(&sums, out);
  }
  Flush(&sums, out);
  float buffer[kBlock];
  for (int j = 0; j < kChunks; ++j) {
    StoreF(out->depth + j * kLanes, deepest[j]);
    for (int k = 0; k < kLanes; ++k) out->depth_block[j * kLanes + k] = static_cast<std::uint32_t>(deepest_block[j][k]);
  }
  StoreF(buffer, room);
  out->room = buffer[0];
  for (int k = 1; k < kLanes; ++k) out->room = buffer[k] < out->room ? buffer[k] : out->room;
  out->room -= in.margin;
}
