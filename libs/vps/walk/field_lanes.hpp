// The field at places in voxels; included by walk_lanes.hpp.

inline F WordDistance(U word) {
  return ToF((I)word) * kWordScale;
}
// Plane of a word at places from its cell's middle, with the gradient (field_word.hpp; every shift leaves the code in
// the seven uppermost bits).
inline F PlaneAndGradient(U word, const Vec3& e, Vec3* g) {
  constexpr std::uint32_t kTop = 0xfe000000U;
  *g = {ToF((I)(word << 11 & kTop)) * kGradientScale, ToF((I)(word << 18 & kTop)) * kGradientScale,
        ToF((I)(word << 25)) * kGradientScale};
  return Dot(*g, e) + WordDistance(word);
}

inline Vec3 Pick(I mask, const Vec3& a, const Vec3& b) {
  return {mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z};
}

// The grid's place nearest to p.
inline Vec3 ClampToGrid(const WalkInput& in, const Vec3& p) {
  return {Min(Max(p.x, F{}), Fill(static_cast<float>(in.nx) - 0.5f)),
          Min(Max(p.y, F{}), Fill(static_cast<float>(in.ny) - 0.5f)),
          Min(Max(p.z, F{}), Fill(static_cast<float>(in.nz) - 0.5f))};
}

// Voxels of places in the grid: the numbers of their bricks, the places of their words there, and the places from their
// middles.
struct Voxel {
  U brick, in_brick;
  Vec3 e;
};
inline Voxel FindVoxel(const WalkInput& in, const Vec3& q) {
  const I x = ToI(q.x);
  const I y = ToI(q.y);
  const I z = ToI(q.z);
  return {(U)(((z >> 3) * (in.ny >> 3) + (y >> 3)) * (in.nx >> 3) + (x >> 3)),
          (U)((x & 3) | (y & 1) << 2 | (z & 1) << 3 | (x >> 2 & 1) << 4 | (y >> 1 & 3) << 5 | (z >> 1 & 3) << 7),
          {q.x - ToF(x) - 0.5f, q.y - ToF(y) - 0.5f, q.z - ToF(z) - 0.5f}};
}
inline U ReadWord(const WalkInput& in, const Voxel& voxel) {
  return Gather(in.words, Gather(in.bricks, voxel.brick) + voxel.in_brick);
}

// The coarse cells of places in the grid, of the masked lanes (CoarseCell), and the places from their middles.
struct Coarse {
  F distance;
  Vec3 g, e;
  I wide, close;  // codes
};
inline Coarse ReadCoarse(const WalkInput& in, const Vec3& q, I lanes) {
  const int shift = in.coarse_shift;
  const I x = ToI(q.x) >> shift;
  const I y = ToI(q.y) >> shift;
  const I z = ToI(q.z) >> shift;
  const U at = (U)(lanes & ((z * (in.ny >> shift) + y) * (in.nx >> shift) + x)) * 2;
  const std::uint32_t* const cells = reinterpret_cast<const std::uint32_t*>(in.coarse);
  const U distance = Gather(cells, at);
  const U code = Gather(cells + 1, at);
  constexpr std::uint32_t kTop = 0xff000000U;
  const float half = static_cast<float>(1 << shift) * 0.5f;
  return {(F)distance,
          {ToF((I)(code << 24 & kTop)) * kCoarseGradientScale, ToF((I)(code << 16 & kTop)) * kCoarseGradientScale,
           ToF((I)(code << 8 & kTop)) * kCoarseGradientScale},
          {q.x - ToF(x << shift) - half, q.y - ToF(y << shift) - half, q.z - ToF(z << shift) - half},
          (I)(distance & 0xffU),
          (I)(code >> 24)};
}

// The records of four words each with these numbers, read whole.
inline void ReadRecords(const std::uint32_t* records, U numbers, U* words) {
  typedef std::uint32_t Four __attribute__((vector_size(16)));
  alignas(64) std::uint32_t number[kLanes];
  alignas(64) std::uint32_t of[4][kLanes];
  StoreU(number, numbers);
  for (int k = 0; k < kLanes; k += 4) {
    Four r[4];
    for (int i = 0; i < 4; ++i) __builtin_memcpy(&r[i], records + std::size_t{number[k + i]} * 4, sizeof r[i]);
    const Four low01 = __builtin_shufflevector(r[0], r[1], 0, 4, 1, 5);
    const Four low23 = __builtin_shufflevector(r[2], r[3], 0, 4, 1, 5);
    const Four high01 = __builtin_shufflevector(r[0], r[1], 2, 6, 3, 7);
    const Four high23 = __builtin_shufflevector(r[2], r[3], 2, 6, 3, 7);
    const Four columns[4] = {
        __builtin_shufflevector(low01, low23, 0, 1, 4, 5), __builtin_shufflevector(low01, low23, 2, 3, 6, 7),
        __builtin_shufflevector(high01, high23, 0, 1, 4, 5), __builtin_shufflevector(high01, high23, 2, 3, 6, 7)};
    for (int i = 0; i < 4; ++i) __builtin_memcpy(of[i] + k, &columns[i], sizeof columns[i]);
  }
  for (int i = 0; i < 4; ++i) words[i] = LoadU(of[i]);
}

// Of a crease's four planes (field_word.hpp) the one that counts.
inline F CreaseAndGradient(const WalkInput& in, U record, const Vec3& e, Vec3* g) {
  static_assert(kPlanesPerCrease == 4);
  U words[4];
  F u[4];
  Vec3 of[4];
  ReadRecords(in.creases, record, words);
  for (int k = 0; k < 4; ++k) u[k] = PlaneAndGradient(words[k], e, &of[k]);
  const F side = (I)(words[0] << 10) < 0 ? Fill(-1.0f) : Fill(1.0f);
  const I is_nested = (I)(words[1] << 10) < 0;
  for (F& value : u) value *= side;
  const I a = (u[0] >= u[1]) ^ is_nested;
  const I b = (u[2] >= u[3]) ^ is_nested;
  const F in_a = a ? u[0] : u[1];
  const F in_b = b ? u[2] : u[3];
  const I is_a = in_a >= in_b;
  *g = Pick(is_a, Pick(a, of[0], of[1]), Pick(b, of[2], of[3]));
  return side * (is_a ? in_a : in_b);
}

// The field at places in voxels, anywhere, as SampleField. `word`: of the voxels of the grid's nearest places.
struct FieldAt {
  F distance;
  Vec3 gradient;
  I is_plane;  // else a crease or a coarse cell
};
__attribute__((always_inline)) inline FieldAt SampleWithGradient(const WalkInput& in, const Vec3& p, U word) {
  const Vec3 q = ClampToGrid(in, p);
  const Vec3 e = FindVoxel(in, q).e;
  FieldAt at;
  at.is_plane = (I)((word & 0x7fU) != kOtherKind);
  at.distance = PlaneAndGradient(word, e, &at.gradient);
  if (Bits(~at.is_plane) != 0) {
    const I is_coarse = (I)(word == kCoarseWord);
    const I is_crease = ~(at.is_plane | is_coarse);
    if (Bits(is_crease) != 0) {
      Vec3 g;
      const F d = CreaseAndGradient(in, (U)(is_crease & (I)(word >> 7)), e, &g);
      at.distance = is_crease ? d : at.distance;
      at.gradient = Pick(is_crease, g, at.gradient);
    }
    if (Bits(is_coarse) != 0) {
      const Coarse cell = ReadCoarse(in, q, is_coarse);
      at.distance = is_coarse ? cell.distance + Dot(cell.g, cell.e) : at.distance;
      at.gradient = Pick(is_coarse, cell.g, at.gradient);
    }
  }
  const F outside = Max(Max(Abs(p.x - q.x), Abs(p.y - q.y)), Abs(p.z - q.z));
  at.distance = outside > 0.0f ? Max(at.distance, outside) : at.distance;
  return at;
}
inline FieldAt SampleWithGradient(const WalkInput& in, const Vec3& p) {
  return SampleWithGradient(in, p, ReadWord(in, FindVoxel(in, ClampToGrid(in, p))));
}
