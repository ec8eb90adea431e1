// The point tests of the walk kernels; included by walk_lanes.hpp.
//
// Blocks go through in batches. First every block: where its points lie in two by two by two bricks, the offsets of
// those eight are one register, and where a lane's word is takes one lookup there. Lanes whose cell is no plane are
// put aside and done in full registers. Then, with all depths known, the sums.

constexpr std::uint32_t kBatch = 32;  // blocks; not derived, measured as a whole in decision 14
// Of a block that lies in the grid but in no two by two by two bricks, and of one that may leave the grid.
constexpr std::uint32_t kWide = 0xfffffffeU;
constexpr std::uint32_t kLeaving = 0xffffffffU;
// Added to a float below 2^21, leaves the nearest integer in the low bits of its word.
constexpr float kRounder = 12582912.0f;

// Per block: the first of its eight bricks and the transform's translation to that brick's corner, less half a voxel so
// that a point rounds to its cell.
struct Windows {
  alignas(64) std::uint32_t slot[kBatch];
  alignas(64) float curvature[kBatch];  // (k1 + k2) / 24 [1/voxel] of the brick that the block's middle is in
  alignas(64) float t[3][kBatch];
};

inline void FindWindows(const WalkInput& in, const std::uint32_t* blocks, std::uint32_t count, Windows* out) {
  constexpr float kPad = 0.1f;  // of a point from the window's faces
  const std::int32_t bricks[3] = {in.nx >> 3, in.ny >> 3, in.nz >> 3};
  alignas(64) float x[kBatch], y[kBatch], z[kBatch], r[kBatch];
  for (std::uint32_t i = 0; i < (count + kLanes - 1) / kLanes * kLanes; ++i) {
    const SphereBlock& spheres = in.spheres[blocks[i] / kBlock];
    const std::uint32_t k = blocks[i] % kBlock;
    x[i] = spheres.x[k];
    y[i] = spheres.y[k];
    z[i] = spheres.z[k];
    r[i] = spheres.r[k];
  }
  for (std::uint32_t i = 0; i < count; i += kLanes) {
    const U block = LoadU(blocks + i);
    const Vec3 c = ToVoxels(in, LoadF(x + i), LoadF(y + i), LoadF(z + i));
    const F reach = LoadF(r + i) * in.voxels_per_m + kPad;
    I is_inside = (I)(block != in.partial_block);
    I fits = is_inside;
    I corner[3];
    I middle[3];
    const F centre[3] = {c.x, c.y, c.z};
    for (int a = 0; a < 3; ++a) {
      const F low = centre[a] - reach;
      const F end = Fill(static_cast<float>(8 * bricks[a]));
      const I limited = I{} + (bricks[a] - 2);
      const I b = ToI(Max(Min(low, end), F{})) >> 3;
      middle[a] = ToI(Max(Min(centre[a], end - 0.5f), F{})) >> 3;
      corner[a] = b < limited ? b : limited;
      is_inside &= (low >= 0.0f) & (centre[a] + reach <= end);
      fits &= centre[a] + reach <= ToF(corner[a] * 8 + 16);
    }
    fits &= is_inside;
    for (int a = 0; a < 3; ++a) StoreF(&out->t[a][i], in.t[a] - ((fits ? ToF(corner[a] * 8) : F{}) + 0.5f));
    const I slot = (corner[2] * bricks[1] + corner[1]) * bricks[0] + corner[0];
    StoreU(&out->slot[i], fits ? (U)slot : (is_inside ? U{} + kWide : U{} + kLeaving));
    const I brick = (middle[2] * bricks[1] + middle[1]) * bricks[0] + middle[0];
    const U both = Gather(in.curvatures, (U)(brick >> 1));
    StoreF(&out->curvature[i], ToF((I)((brick & 1) != 0 ? both : both << 16) >> 16) * (kCurvatureStep / 24.0f));
  }
}

// Lanes put aside: words of crease cells with the place in the cell; points of the coarse grid; `to` is the
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

// The lanes behind the last repeat it. Returns how many there are with them.
inline std::uint32_t FillUp(Aside* aside) {
  const std::uint32_t n = aside->count;
  std::uint32_t k = n;
  for (; k % kLanes != 0; ++k) {
    aside->word[k] = aside->word[n - 1];
    aside->x[k] = aside->x[n - 1];
    aside->y[k] = aside->y[n - 1];
    aside->z[k] = aside->z[n - 1];
    aside->to[k] = aside->to[n - 1];
  }
  return k;
}

inline void StoreDepths(F d, const std::uint32_t* to, float* depths) {
  float buffer[kLanes];
  StoreF(buffer, -d);
  for (int k = 0; k < kLanes; ++k) depths[to[k]] = buffer[k];
}

// Whole records are read lane by lane: that takes the processors less time than a gather for each of their words.
typedef std::uint32_t U4 __attribute__((vector_size(16)));
inline U4 LoadU4(const std::uint32_t* p) {
  U4 v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}
inline void StoreU4(std::uint32_t* p, U4 v) {
  __builtin_memcpy(p, &v, sizeof v);
}

inline void EvaluateCreases(const WalkInput& in, Aside* creases, float* depths) {
  static_assert(kPlanesPerCrease == 4);
  alignas(64) std::uint32_t planes[4][Aside::kMost];
  const std::uint32_t count = FillUp(creases);
  for (std::uint32_t k = 0; k < count; k += 4) {
    const U4 r0 = LoadU4(in.creases + (creases->word[k] >> 7) * 4);
    const U4 r1 = LoadU4(in.creases + (creases->word[k + 1] >> 7) * 4);
    const U4 r2 = LoadU4(in.creases + (creases->word[k + 2] >> 7) * 4);
    const U4 r3 = LoadU4(in.creases + (creases->word[k + 3] >> 7) * 4);
    const U4 low01 = __builtin_shufflevector(r0, r1, 0, 4, 1, 5);
    const U4 low23 = __builtin_shufflevector(r2, r3, 0, 4, 1, 5);
    const U4 high01 = __builtin_shufflevector(r0, r1, 2, 6, 3, 7);
    const U4 high23 = __builtin_shufflevector(r2, r3, 2, 6, 3, 7);
    StoreU4(planes[0] + k, __builtin_shufflevector(low01, low23, 0, 1, 4, 5));
    StoreU4(planes[1] + k, __builtin_shufflevector(low01, low23, 2, 3, 6, 7));
    StoreU4(planes[2] + k, __builtin_shufflevector(high01, high23, 0, 1, 4, 5));
    StoreU4(planes[3] + k, __builtin_shufflevector(high01, high23, 2, 3, 6, 7));
  }
  for (std::uint32_t k = 0; k < count; k += kLanes) {
    const Vec3 e{LoadF(creases->x + k), LoadF(creases->y + k), LoadF(creases->z + k)};
    const F d = CreaseFrom(LoadU(planes[0] + k), LoadU(planes[1] + k), LoadU(planes[2] + k), LoadU(planes[3] + k), e);
    StoreDepths(d, creases->to + k, depths);
  }
}

inline void EvaluateCoarse(const WalkInput& in, Aside* coarse, float* depths) {
  alignas(64) std::uint32_t distance[Aside::kMost];
  const auto* const cells = reinterpret_cast<const std::uint32_t*>(in.coarse);
  const std::uint32_t count = FillUp(coarse);
  for (std::uint32_t k = 0; k < count; k += kLanes) {
    Vec3 e;
    StoreU(coarse->word + k, CoarseCellAt(in, {LoadF(coarse->x + k), LoadF(coarse->y + k), LoadF(coarse->z + k)}, &e));
    StoreF(coarse->x + k, e.x);
    StoreF(coarse->y + k, e.y);
    StoreF(coarse->z + k, e.z);
  }
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::uint32_t* const cell = cells + std::size_t{coarse->word[k]} * 2;
    distance[k] = cell[0];
    coarse->word[k] = cell[1];
  }
  for (std::uint32_t k = 0; k < count; k += kLanes) {
    const Vec3 e{LoadF(coarse->x + k), LoadF(coarse->y + k), LoadF(coarse->z + k)};
    StoreDepths(CoarseFrom(LoadU(distance + k), LoadU(coarse->word + k), e), coarse->to + k, depths);
  }
}

// The field around the points of a window's block, kept in registers from block to block.
struct WindowReader {
  F m[3][3];
  Place place_x, place_y, place_z;
  const std::uint32_t* bricks;
  std::size_t stride_y, stride_z;
  float last[3];  // of the grid's cells

  explicit WindowReader(const WalkInput& in)
      : place_x(LoadPlace(kPlaceX)),
        place_y(LoadPlace(kPlaceY)),
        place_z(LoadPlace(kPlaceZ)),
        bricks(in.bricks),
        stride_y(static_cast<std::size_t>(in.nx >> 3)),
        stride_z(stride_y * static_cast<std::size_t>(in.ny >> 3)),
        last{static_cast<float>(in.nx - 1), static_cast<float>(in.ny - 1), static_cast<float>(in.nz - 1)} {
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) m[a][b] = Fill(in.m[a][b]);
    }
  }
  // Indices of the words of the points' cells; e: places in the cells.
  U Find(const PointBlock& block, int at, const Windows& windows, std::uint32_t i, const Octet& octet, Vec3* e) const {
    Vec3 r;
    Round(ToWindow(block, at, windows, i), &r, e);
    const U cell = PlaceOf(place_x, (U)r.x) + PlaceOf(place_y, (U)r.y) + PlaceOf(place_z, (U)r.z);
    return LookUp(octet, cell >> kPlaceBrickShift) + cell;
  }
  // The same of a wide block, whose window is the grid, within the points' bricks; of a leaving one, for the grid's
  // places nearest to its points. brick: where their first words' indices are.
  U FindWide(const PointBlock& block, int at, const Windows& windows, std::uint32_t i, U* brick, Vec3* e) const {
    Vec3 p = ToWindow(block, at, windows, i);
    if (windows.slot[i] == kLeaving) {
      p = {Max(Min(p.x, Fill(last[0])), Fill(-0.5f)), Max(Min(p.y, Fill(last[1])), Fill(-0.5f)),
           Max(Min(p.z, Fill(last[2])), Fill(-0.5f))};
    }
    Vec3 r;
    Round(p, &r, e);
    const F zero = Fill(kRounder);
    const I x = (I)r.x - (I)zero;
    const I y = (I)r.y - (I)zero;
    const I z = (I)r.z - (I)zero;
    *brick =
        (U)((z >> 3) * static_cast<std::int32_t>(stride_z) + (y >> 3) * static_cast<std::int32_t>(stride_y) + (x >> 3));
    return WordInBrickOf(x, y, z);
  }

 private:
  Vec3 ToWindow(const PointBlock& block, int at, const Windows& windows, std::uint32_t i) const {
    const F x = LoadF(block.x + at);
    const F y = LoadF(block.y + at);
    const F z = LoadF(block.z + at);
    return {Fma(m[0][0], x, Fma(m[0][1], y, Fma(m[0][2], z, Fill(windows.t[0][i])))),
            Fma(m[1][0], x, Fma(m[1][1], y, Fma(m[1][2], z, Fill(windows.t[1][i])))),
            Fma(m[2][0], x, Fma(m[2][1], y, Fma(m[2][2], z, Fill(windows.t[2][i]))))};
  }
  // r: the window's cells plus kRounder.
  static void Round(const Vec3& p, Vec3* r, Vec3* e) {
    *r = {p.x + kRounder, p.y + kRounder, p.z + kRounder};
    *e = {p.x - (r->x - kRounder), p.y - (r->y - kRounder), p.z - (r->z - kRounder)};
  }
};

// The words and places of a batch's points. Found for all of them before the first word is read: so the many misses of
// the caches overlap, instead of waiting behind the arithmetic of one block.
struct Cells {
  alignas(64) std::uint32_t word[kBatch * kBlock];  // its index, then the word itself
  alignas(64) float x[kBatch * kBlock], y[kBatch * kBlock], z[kBatch * kBlock];
};

inline void StoreCells(std::uint32_t to, U index, const Vec3& e, Cells* cells) {
  StoreU(cells->word + to, index);
  StoreF(cells->x + to, e.x);
  StoreF(cells->y + to, e.y);
  StoreF(cells->z + to, e.z);
}

inline void Prefetch(const PointBlock& block) {
  __builtin_prefetch(block.x);
  __builtin_prefetch(block.y);
  __builtin_prefetch(block.z);
}

inline void ReadCells(const WalkInput& in, const std::uint32_t* blocks, std::uint32_t count, const Windows& windows,
                      Cells* cells) {
  constexpr std::uint32_t kAhead = 8;  // blocks prefetched ahead; not derived
  const WindowReader reader(in);
  alignas(64) std::uint32_t wide_bricks[kBatch * kBlock];
  std::uint32_t num_wide = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    Prefetch(in.points[blocks[i + kAhead]]);
    if (windows.slot[i] >= kWide) {
      for (int at = 0; at < static_cast<int>(kBlock); at += kLanes) {
        Vec3 e;
        U brick;
        const U index = reader.FindWide(in.points[blocks[i]], at, windows, i, &brick, &e);
        StoreCells(i * kBlock + static_cast<std::uint32_t>(at), index, e, cells);
        StoreU(wide_bricks + num_wide, brick);
        num_wide += kLanes;
      }
      continue;
    }
    const Octet octet = LoadOctet(reader.bricks + windows.slot[i], reader.stride_y, reader.stride_z);
    const PointBlock& block = in.points[blocks[i]];
    for (int at = 0; at < static_cast<int>(kBlock); at += kLanes) {
      Vec3 e;
      const U index = reader.Find(block, at, windows, i, octet, &e);
      StoreCells(i * kBlock + static_cast<std::uint32_t>(at), index, e, cells);
    }
  }
  std::uint32_t next = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    std::uint32_t* const word = cells->word + i * kBlock;
    if (windows.slot[i] >= kWide) {
      for (std::uint32_t k = 0; k < kBlock; ++k) word[k] = in.words[word[k] + in.bricks[wide_bricks[next++]]];
    } else {
      for (std::uint32_t k = 0; k < kBlock; ++k) word[k] = in.words[word[k]];
    }
  }
}

// Gradients of the field at a batch's points, 1 / kGradientScale; x above kNoSlope where the word is no plane.
struct Slopes {
  alignas(64) float x[kBatch * kBlock], y[kBatch * kBlock], z[kBatch * kBlock];
};
constexpr float kNoSlope = 1e20f;

// Depths of a batch at the points' places.
inline void FindDepths(const WalkInput& in, const std::uint32_t* blocks, std::uint32_t count, const Windows& windows,
                       float* depths, Slopes* slopes) {
  Cells cells;
  ReadCells(in, blocks, count, windows, &cells);
  // Without a branch on what is read: a wrong guess would wait for memory.
  alignas(64) std::uint32_t odd[kBatch];
  unsigned lanes_of[kBatch];
  std::uint32_t num_odd = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    unsigned found = 0;
    for (int at = 0; at < static_cast<int>(kBlock); at += kLanes) {
      const std::uint32_t to = i * kBlock + static_cast<std::uint32_t>(at);
      const U word = LoadU(cells.word + to);
      const U z_code = word << 25;
      constexpr std::uint32_t kTop = 0xfe000000U;
      const Vec3 g{ToF((I)(word << 11 & kTop)), ToF((I)(word << 18 & kTop)), ToF((I)z_code)};
      const Vec3 e{LoadF(cells.x + to), LoadF(cells.y + to), LoadF(cells.z + to)};
      const F depth = Fma(ToF((I)word), Fill(kWordScale / kGradientScale), Dot(g, e)) * -kGradientScale;
      const U is_other = (U)(z_code == (kOtherKind << 25));
      StoreF(depths + to, depth);
      StoreF(slopes->x + to, is_other ? Fill(2.0f * kNoSlope) : g.x);
      StoreF(slopes->y + to, g.y);
      StoreF(slopes->z + to, g.z);
      found |= EqualBits(z_code, U{} + (kOtherKind << 25)) << at;
    }
    odd[num_odd] = i;
    lanes_of[num_odd] = found;
    num_odd += found != 0 ? 1 : 0;
  }
  Aside creases;
  Aside coarse;
  creases.count = coarse.count = 0;
  for (std::uint32_t k = 0; k < num_odd; ++k) {
    const std::uint32_t i = odd[k];
    const PointBlock& block = in.points[blocks[i]];
    for (int at = 0; at < static_cast<int>(kBlock); at += kLanes) {
      const std::uint32_t first = i * kBlock + static_cast<std::uint32_t>(at);
      const Vec3 q = ClampToGrid(in, ToVoxels(in, LoadF(block.x + at), LoadF(block.y + at), LoadF(block.z + at)));
      const U to = LaneNumbers() + first;
      const U word = LoadU(cells.word + first);
      const unsigned lanes = lanes_of[k] >> at & kAllLanes;
      const unsigned coarse_lanes = EqualBits(word, U{} + kCoarseWord);
      if (coarse_lanes != 0) PutAside(q, to, coarse_lanes, &coarse);
      Compress(creases.word + creases.count, word, lanes & ~coarse_lanes);
      PutAside({LoadF(cells.x + first), LoadF(cells.y + first), LoadF(cells.z + first)}, to, lanes & ~coarse_lanes,
               &creases);
    }
  }
  if (creases.count > 0) EvaluateCreases(in, &creases, depths);
  if (coarse.count > 0) EvaluateCoarse(in, &coarse, depths);
  for (std::uint32_t i = 0; i < count; ++i) {
    if (windows.slot[i] != kLeaving) continue;
    const PointBlock& block = in.points[blocks[i]];
    for (int at = 0; at < static_cast<int>(kBlock); at += kLanes) {
      const Vec3 p = ToVoxels(in, LoadF(block.x + at), LoadF(block.y + at), LoadF(block.z + at));
      const Vec3 q = ClampToGrid(in, p);
      const F outside = Max(Max(Abs(p.x - q.x), Abs(p.y - q.y)), Abs(p.z - q.z));
      float* const depth = depths + i * kBlock + at;
      StoreF(depth, outside > 0.0f ? Min(LoadF(depth), -outside) : LoadF(depth));
    }
  }
}

// Mean depth over a point's patch, of a positive depth d at its centroid (decision 10). To second order the distance of
// G has the mean  d_G + tr(H C) / 2  over the patch: H are its second derivatives with the trace k1 + k2 (the principal
// curvatures, k1 + k2 [1/voxel]), C the patch's second moments, about area / 12 in both directions of the surface, so
//
//   mean depth = d - area (k1 + k2) / 24   [voxels],
//
// changed by at most half of d, so that the force is continuous at d = 0.
inline F MeanDepth(const WalkInput& in, F depth, F area, float curvature) {
  const F less = area * (in.voxels_per_m * in.voxels_per_m * curvature);
  const F most = depth * 0.5f;
  return depth > 0.0f ? depth - Max(Min(less, most), -most) : depth;
}

// Sums in float of the blocks whose numbers differ only in the last five bits, then added to the doubles: the sums do
// not depend on which blocks beyond the margin were tested as well.
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
    for (std::uint32_t k = 0; k < kBlock; k += 4) {
      typedef float Floats __attribute__((vector_size(16)));
      typedef double Doubles __attribute__((vector_size(32)));
      Floats part;
      Doubles sum;
      __builtin_memcpy(&part, buffer + k, sizeof part);
      __builtin_memcpy(&sum, sums->of[s] + k, sizeof sum);
      sum += __builtin_convertvector(part, Doubles);
      __builtin_memcpy(sums->of[s] + k, &sum, sizeof sum);
    }
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

// What the samples near the zero level miss: a sample counts max(d, 0), but the depth varies over its cell, and a cell
// that is cut by the zero level has more. With the depth d + s, s spread evenly over [-w / 2, w / 2], the mean exceeds
// max(d, 0) by
//
//   (w / 2 - |d|)^2 / (2 w)   while |d| < w / 2, else by 0.
//
// w = h sqrt(|g|^2 - (g . n)^2): how much a linear depth changes over a cell of side h; g is the field's gradient, the
// root its part along the surface. Where several of G's facets are near it is taken as 1, the most that is possible.
inline void AddMissed(const WalkInput& in, const PointBlock& block, const F* depth, const Slopes& slopes,
                      std::uint32_t first, Partial* partial) {
  for (int j = 0; j < kParts; ++j) {
    const int at = j * kLanes;
    const F area = LoadF(block.area_m2 + at);
    const F h2 = area * (in.voxels_per_m * in.voxels_per_m);
    if (LessBits(depth[j] * depth[j] * 4.0f, h2) == 0) continue;
    const std::uint32_t k = first + static_cast<std::uint32_t>(at);
    const Vec3 g{LoadF(slopes.x + k), LoadF(slopes.y + k), LoadF(slopes.z + k)};
    const Vec3 n = Turn(in, LoadF(block.nx + at), LoadF(block.ny + at), LoadF(block.nz + at));
    const F along = Dot(g, n) * in.m_per_voxel;
    const F slope2 = Min(Max(Dot(g, g) - along * along, F{}) * (kGradientScale * kGradientScale), Fill(1.0f));
    const F w = Sqrt((g.x < kNoSlope ? slope2 : Fill(1.0f)) * h2);
    const F within = Max(w * 0.5f - Abs(depth[j]), F{});
    const F missed = within > 0.0f ? area * (within * within / (w * 2.0f)) : F{};
    partial->of[WalkSums::kMissed][j] += missed;
    partial->of[WalkSums::kMissedSquared][j] = Fma(missed, missed, partial->of[WalkSums::kMissedSquared][j]);
    partial->is_empty = false;
  }
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
  // d <= margin, as the next smaller float < depth.
  const F least = Fill(__builtin_nextafterf(-in.margin, -1e30f));
  alignas(64) std::uint32_t ids[2 * kBatch];
  alignas(64) float depths[kBatch * kBlock];
  Slopes slopes;
  std::uint32_t near_at[kBatch];
  F shallowest = Fill(-1e30f);
  for (std::uint32_t begin = 0; begin < chunk.num_blocks; begin += kBatch) {
    const std::uint32_t left = chunk.num_blocks - begin;
    const std::uint32_t count = left < kBatch ? left : kBatch;
    for (std::uint32_t k = 0; k < 2 * kBatch; ++k) ids[k] = chunk.blocks[begin + (k < left ? k : 0)];
    Windows windows;
    FindWindows(in, ids, count, &windows);
    FindDepths(in, ids, count, windows, depths, &slopes);
    std::uint32_t num_near = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      unsigned near = 0;
      for (int j = 0; j < kParts; ++j) {
        const F depth = LoadF(depths + i * kBlock + j * kLanes);
        near |= LessBits(least, depth) << j * kLanes;
        shallowest = Max(shallowest, depth);
      }
      near_at[num_near] = i;
      num_near += near != 0 ? 1 : 0;
      sums->num_near += static_cast<std::uint32_t>(__builtin_popcount(near));
    }
    for (std::uint32_t n = 0; n < num_near; ++n) {
      const std::uint32_t id = ids[near_at[n]];
      const PointBlock& block = in.points[id];
      F depth[kParts];
      unsigned colliding = 0;
      float* const near_depths = chunk.near_depths[sums->num_near_blocks];
      chunk.near_blocks[sums->num_near_blocks++] = id;
      for (int j = 0; j < kParts; ++j) {
        const F at_point = LoadF(depths + near_at[n] * kBlock + j * kLanes);
        colliding |= LessBits(F{}, at_point) << j * kLanes;
        depth[j] = MeanDepth(in, at_point, LoadF(block.area_m2 + j * kLanes), windows.curvature[near_at[n]]);
        StoreF(near_depths + j * kLanes, depth[j]);
        const I is_deeper = depth[j] > deepest[j];
        deepest[j] = is_deeper ? depth[j] : deepest[j];
        deepest_block[j] = is_deeper ? I{} + static_cast<std::int32_t>(id) : deepest_block[j];
      }
      sums->num_colliding += static_cast<std::uint32_t>(__builtin_popcount(colliding));
      if (id >> kSharedBits != partial.group) {
        Flush(&partial, sums);
        partial.group = id >> kSharedBits;
      }
      AddMissed(in, block, depth, slopes, near_at[n] * kBlock, &partial);
      if (colliding != 0) AddBlock(block, depth, &partial);
    }
  }
  Flush(&partial, sums);
  for (int j = 0; j < kParts; ++j) {
    StoreF(sums->depth + j * kLanes, deepest[j]);
    StoreU(sums->depth_block + j * kLanes, (U)deepest_block[j]);
  }
  sums->free_distance = -Most(shallowest);
}
