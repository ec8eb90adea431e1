// Exact distances to the surface's triangles; included by walk_lanes.hpp.
//
// A triangle lies in a frame of its own: corner A at the origin, B on the x axis, C beside it in the x-y plane, z out
// of the solid. A block's sixteen are unpacked lane by lane; then each of them that can be nearest meets sixteen
// points.

inline Vec3 Minus(const Vec3& a, const Vec3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3 Times(const Vec3& a, F s) {
  return {a.x * s, a.y * s, a.z * s};
}
inline Vec3 Cross(const Vec3& a, const Vec3& b) {
  return {Fma(a.y, b.z, -(a.z * b.y)), Fma(a.z, b.x, -(a.x * b.z)), Fma(a.x, b.y, -(a.y * b.x))};
}

// The corners of a block and their numbers, widened.
struct FacetCorners {
  alignas(64) float at[3][kFacetLanes];
  alignas(64) std::uint32_t number[kFacetLanes];
};

// With lengths l the products of a triangle's frame are off by some 2^-22 l. Below a height over AB of 2^-18 l that
// turns the frame about AB by a tenth of a radian and more, in the end any way, and leaves axes that are not of unit
// length: the triangle is a line then, in a frame that is turned anyhow. Which side of it a point is on is not to be
// relied on below 2^-12 l: it counts as 2^-18 l farther away, many times what the distances of its neighbours are
// rounded by, so that a point over an edge that they share has their side.
constexpr float kLine = 0x1p-18f;
constexpr float kSliver = 0x1p-12f;
constexpr float kYields = 0x1p-18f;

// Of unit length, across a unit vector.
inline Vec3 AnyAcross(const Vec3& u) {
  const I is_along_x = (I)(Abs(u.x) > 0.6f);
  const Vec3 across = Cross(u, {is_along_x ? F{} : Fill(1.0f), is_along_x ? Fill(1.0f) : F{}, F{}});
  return Times(across, 1.0f / Length(across));
}

inline void Unpack(const FacetBlock& block, float x, float y, float z, FacetFrames* out) {
  FacetCorners corners;
  for (std::uint32_t k = 0; k < kFacetLanes; ++k) {
    corners.at[0][k] = x + kFacetStep * static_cast<float>(block.x[k]);
    corners.at[1][k] = y + kFacetStep * static_cast<float>(block.y[k]);
    corners.at[2][k] = z + kFacetStep * static_cast<float>(block.z[k]);
    corners.number[k] = block.corners[k];
  }
  for (int at = 0; at < static_cast<int>(kFacetLanes); at += kLanes) {
    const U number = LoadU(corners.number + at);
    const auto corner = [&](int k) {
      const U n = number >> 4 * k & 15U;
      const auto of_axis = [&](int i) { return (F)Gather(reinterpret_cast<const std::uint32_t*>(corners.at[i]), n); };
      return Vec3{of_axis(0), of_axis(1), of_axis(2)};
    };
    const Vec3 a = corner(0);
    const Vec3 ab = Minus(corner(1), a);
    const Vec3 ac = Minus(corner(2), a);
    const F b = Length(ab);
    const Vec3 u = Times(ab, 1.0f / b);
    const F cx = Dot(ac, u);
    const Vec3 across = Minus(ac, Times(u, cx));
    constexpr float kLeastHeight = 1e-6f;  // voxels, a fifteenth of a step; against division by 0
    const F height = Length(across);
    const F cy = Max(height, Fill(kLeastHeight));
    const F ex = cx - b;
    const F squared_ac = Fma(cx, cx, cy * cy);
    const F squared_bc = Fma(ex, ex, cy * cy);
    const F longest = Sqrt(Max(b * b, Max(squared_ac, squared_bc)));
    const I is_line = (I)(height < kLine * longest) | (I)(height < kLeastHeight);
    const Vec3 upright = Times(across, 1.0f / cy);
    const Vec3 turned = AnyAcross(u);
    const Vec3 v = Pick(is_line, turned, upright);
    const Vec3 n = Cross(u, v);
    // Around all corners: the middle of the triangle's box in its own plane.
    const F low = Min(cx, F{});
    const F high = Max(cx, b);
    const F mx = 0.5f * (low + high);
    const F my = 0.5f * cy;
    const F half = 0.5f * (high - low);
    Store(a, out->ax + at, out->ay + at, out->az + at);
    Store(u, out->ux + at, out->uy + at, out->uz + at);
    Store(v, out->vx + at, out->vy + at, out->vz + at);
    Store(n, out->nx + at, out->ny + at, out->nz + at);
    StoreF(out->b + at, b);
    StoreF(out->cx + at, cx);
    StoreF(out->cy + at, cy);
    StoreF(out->inverse_bc + at, 1.0f / squared_bc);
    StoreF(out->inverse_ca + at, 1.0f / squared_ac);
    StoreF(out->mx + at, mx);
    StoreF(out->my + at, my);
    StoreF(out->half_x + at, half);
    StoreF(out->yields + at, height < kSliver * longest ? kYields * longest : F{});
    StoreF(out->doubt + at, (I)(number & std::uint32_t{kDoubtful}) != 0 ? Fill(kDoubt) : F{});
  }
}

// Sixteen points, a sphere around them, and their nearest triangles so far.
struct FacetTarget {
  Vec3 p[kParts];
  F key[kParts];      // squared distance, and a little more beside the face
  F squared[kParts];  // squared distance; negative where there is none yet or its side is doubtful
  F height[kParts];   // over the plane: its sign is the side
  Vec3 away[kParts];  // the face's normal, or beside it the way from the nearest place
  I is_beside[kParts];
  float c[3];
  float r;
};

// Penalty on the squared distance beside a triangle's face: key = squared + kBeside * (squared distance within the
// plane). Of triangles that share the nearest edge or corner, squared distances are equal, so that the one whose plane
// is farthest from the point wins: its side is the sign. Not derived: above the rounding of floats, below any
// difference that matters.
constexpr float kBeside = 1e-3f;

inline void MeetFacet(const FacetFrames& f, std::uint32_t k, FacetTarget* to) {
  const Vec3 a{Fill(f.ax[k]), Fill(f.ay[k]), Fill(f.az[k])};
  const Vec3 u{Fill(f.ux[k]), Fill(f.uy[k]), Fill(f.uz[k])};
  const Vec3 v{Fill(f.vx[k]), Fill(f.vy[k]), Fill(f.vz[k])};
  const Vec3 n{Fill(f.nx[k]), Fill(f.ny[k]), Fill(f.nz[k])};
  const F b = Fill(f.b[k]);
  const F cx = Fill(f.cx[k]);
  const F cy = Fill(f.cy[k]);
  const F ex = cx - b;
  const F one = Fill(1.0f);
  const float yields = f.yields[k];
  for (int j = 0; j < kParts; ++j) {
    const Vec3 d = Minus(to->p[j], a);
    const F x = Dot(d, u);
    const F y = Dot(d, v);
    const F h = Dot(d, n);
    const F wx = x - b;
    const F off_ab = x - Max(Min(x, b), F{});
    const F q_ab = Fma(off_ab, off_ab, y * y);
    const F t_bc = Max(Min(Fma(wx, ex, y * cy) * f.inverse_bc[k], one), F{});
    const F bc_x = Fma(-t_bc, ex, wx);
    const F bc_y = Fma(-t_bc, cy, y);
    const F q_bc = Fma(bc_x, bc_x, bc_y * bc_y);
    const F t_ca = Max(Min(Fma(x, cx, y * cy) * f.inverse_ca[k], one), F{});
    const F ca_x = Fma(-t_ca, cx, x);
    const F ca_y = Fma(-t_ca, cy, y);
    const F q_ca = Fma(ca_x, ca_x, ca_y * ca_y);
    const I is_beside = (y < 0.0f) | (Fma(ex, y, -(cy * wx)) < 0.0f) | (Fma(cx, y, -(cy * x)) > 0.0f);
    const F least = Min(q_ab, Min(q_bc, q_ca));
    const F beside = is_beside ? least : F{};
    const F in_x = least == q_ab ? off_ab : (least == q_bc ? bc_x : ca_x);
    const F in_y = least == q_ab ? y : (least == q_bc ? bc_y : ca_y);
    const F up = is_beside ? h : Fill(1.0f);
    const F along_x = is_beside ? in_x : F{};
    const F along_y = is_beside ? in_y : F{};
    const F squared = Fma(h, h, beside);
    F key = Fma(beside, Fill(kBeside), squared);
    if (yields > 0.0f) {
      const F farther = Sqrt(key) + yields;
      key = farther * farther;
    }
    const I is_nearer = key < to->key[j];
    to->key[j] = is_nearer ? key : to->key[j];
    to->squared[j] = is_nearer ? squared - f.doubt[k] : to->squared[j];
    to->height[j] = is_nearer ? h : to->height[j];
    to->is_beside[j] = is_nearer ? is_beside : to->is_beside[j];
    Vec3& away = to->away[j];
    away.x = is_nearer ? Fma(along_x, u.x, Fma(along_y, v.x, up * n.x)) : away.x;
    away.y = is_nearer ? Fma(along_x, u.y, Fma(along_y, v.y, up * n.y)) : away.y;
    away.z = is_nearer ? Fma(along_x, u.z, Fma(along_y, v.z, up * n.z)) : away.z;
  }
}

// Lower bounds of the distances of a block's triangles from the target's sphere, squared; 0 where they reach it. A
// triangle lies in the box of its frame, mx +- half_x by my +- my by 0.
inline F BoundFacets(const FacetFrames& f, int at, const FacetTarget& to) {
  const Vec3 d{to.c[0] - LoadF(f.ax + at), to.c[1] - LoadF(f.ay + at), to.c[2] - LoadF(f.az + at)};
  const F x = Dot(d, {LoadF(f.ux + at), LoadF(f.uy + at), LoadF(f.uz + at)});
  const F y = Dot(d, {LoadF(f.vx + at), LoadF(f.vy + at), LoadF(f.vz + at)});
  const F h = Dot(d, {LoadF(f.nx + at), LoadF(f.ny + at), LoadF(f.nz + at)});
  const F my = LoadF(f.my + at);
  const F off_x = Max(Abs(x - LoadF(f.mx + at)) - LoadF(f.half_x + at), F{});
  const F off_y = Max(Abs(y - my) - my, F{});
  const F bound = Max(Sqrt(Fma(off_x, off_x, Fma(off_y, off_y, h * h))) - (to.r + 1e-3f), F{});
  return bound * bound;
}

inline float Most(F v) {
  return -Least(-v);
}
inline F Most(const F* of_parts) {
  F most = of_parts[0];
  for (int j = 1; j < kParts; ++j) most = Max(of_parts[j], most);
  return Fill(Most(most));
}

// The spheres of a block of them that come as near to a place as `reach`; appends their numbers.
inline std::uint32_t TakeSpheres(const FacetSpheres& s, const float* c, float reach, U numbers, int at,
                                 std::uint32_t* to) {
  const Vec3 d{c[0] - LoadF(s.x + at), c[1] - LoadF(s.y + at), c[2] - LoadF(s.z + at)};
  const F most = LoadF(s.r + at) + reach;
  const unsigned lanes = LessBits(Dot(d, d), most * most);
  if (lanes == 0) return 0;
  Compress(to, numbers, lanes);
  return static_cast<std::uint32_t>(__builtin_popcount(lanes));
}

// Blocks that come as near to a place as `reach`, with their spheres. False: more than kMostFacetBlocks, or G has none.
inline bool FindFacetBlocks(const WalkInput& in, const float* c, float reach, NearFacets* near) {
  if (in.num_facet_levels == 0) return false;
  alignas(64) std::uint32_t queues[2][kMostFacetBlocks + 2 * kFacetLanes];
  std::uint32_t size = 1;
  queues[0][0] = 0;
  const std::uint32_t* queue = queues[0];
  for (std::uint32_t level = in.num_facet_levels; level-- > 0;) {
    std::uint32_t* const next = level == 0 ? near->block : (queue == queues[0] ? queues[1] : queues[0]);
    std::uint32_t num_next = 0;
    for (std::uint32_t i = 0; i < size; ++i) {
      const FacetSpheres& s = in.facet_spheres[in.facet_level_begin[level] + queue[i]];
      for (int at = 0; at < static_cast<int>(kFacetLanes); at += kLanes) {
        const U numbers = LaneNumbers() + (queue[i] * kFacetLanes + static_cast<std::uint32_t>(at));
        num_next += TakeSpheres(s, c, reach, numbers, at, next + num_next);
      }
      if (num_next > kMostFacetBlocks) return false;
    }
    queue = next;
    size = num_next;
  }
  for (std::uint32_t k = 0; k < (size + kFacetLanes - 1) / kFacetLanes * kFacetLanes; ++k) {
    FacetSpheres& to = near->spheres[k / kFacetLanes];
    const std::uint32_t lane = k % kFacetLanes;
    const bool is_used = k < size;
    const FacetSpheres& from = in.facet_spheres[is_used ? near->block[k] / kFacetLanes : 0];
    const std::uint32_t from_lane = is_used ? near->block[k] % kFacetLanes : 0;
    to.x[lane] = is_used ? from.x[from_lane] : Facets::kFarAway;
    to.y[lane] = from.y[from_lane];
    to.z[lane] = from.z[from_lane];
    to.r[lane] = from.r[from_lane];
  }
  near->count = size;
  near->reach = reach;
  for (int i = 0; i < 3; ++i) near->c[i] = c[i];
  return true;
}

inline void FindTarget(const WalkInput& in, const FacetPoints& points, FacetTarget* to) {
  Vec3 low{Fill(1e30f), Fill(1e30f), Fill(1e30f)};
  Vec3 high{-low.x, -low.y, -low.z};
  for (int j = 0; j < kParts; ++j) {
    const int at = j * kLanes;
    const Vec3 p = ToVoxels(in, LoadF(points.x + at), LoadF(points.y + at), LoadF(points.z + at));
    low = {Min(low.x, p.x), Min(low.y, p.y), Min(low.z, p.z)};
    high = {Max(high.x, p.x), Max(high.y, p.y), Max(high.z, p.z)};
    to->p[j] = p;
    to->squared[j] = Fill(kUnmet);
  }
  to->c[0] = 0.5f * (Least(low.x) + Most(high.x));
  to->c[1] = 0.5f * (Least(low.y) + Most(high.y));
  to->c[2] = 0.5f * (Least(low.z) + Most(high.z));
  F squared[kParts];
  for (int j = 0; j < kParts; ++j) {
    const Vec3 d{to->p[j].x - to->c[0], to->p[j].y - to->c[1], to->p[j].z - to->c[2]};
    squared[j] = Dot(d, d);
  }
  to->r = Sqrt(Most(squared))[0];
}

// Initial search radius of the points that have met no triangle: |depth by the field| + slack.
inline void StartFacets(const FacetPoints& points, float slack, FacetTarget* to) {
  for (int j = 0; j < kParts; ++j) {
    const F reach = Abs(LoadF(points.depth + j * kLanes)) + slack;
    to->key[j] = to->squared[j] == kUnmet ? reach * reach : F{};
  }
}

inline void MeetBlock(const WalkInput& in, std::uint32_t block, FacetScratch* scratch, FacetTarget* to) {
  const std::uint32_t slot = block % kFacetSlots;
  FacetFrames& frames = scratch->frames[slot];
  if (scratch->block[slot] != block) {
    scratch->block[slot] = block;
    const FacetSpheres& s = in.facet_spheres[block / kFacetLanes];
    const std::uint32_t lane = block % kFacetLanes;
    Unpack(in.facet_blocks[block], s.x[lane], s.y[lane], s.z[lane], &frames);
  }
  const F most = Most(to->key);
  unsigned near = 0;
  for (int at = 0; at < static_cast<int>(kFacetLanes); at += kLanes) {
    near |= LessBits(BoundFacets(frames, at, *to), most) << at;
  }
  for (; near != 0; near &= near - 1) MeetFacet(frames, static_cast<std::uint32_t>(__builtin_ctz(near)), to);
}

// Tests the triangles within the points' keys. False: too many. Consecutive groups are neighbours: the search around
// one is kAround voxels wider, so that the next ones need none. Not derived.
inline bool MeetFacets(const WalkInput& in, FacetScratch* scratch, FacetTarget* to) {
  constexpr float kAround = 1.0f;  // voxels
  const float reach = to->r + Sqrt(Most(to->key))[0];
  NearFacets& near = scratch->near;
  const float d[3] = {to->c[0] - near.c[0], to->c[1] - near.c[1], to->c[2] - near.c[2]};
  const float room = near.reach - reach;
  if (!(room > 0.0f) || d[0] * d[0] + d[1] * d[1] + d[2] * d[2] > room * room) {
    near.reach = 0.0f;
    if (!FindFacetBlocks(in, to->c, reach + kAround, &near)) return false;
  }
  alignas(64) std::uint32_t blocks[kMostFacetBlocks + 2 * kFacetLanes];
  std::uint32_t count = 0;
  for (std::uint32_t k = 0; k < near.count; k += kFacetLanes) {
    for (int at = 0; at < static_cast<int>(kFacetLanes); at += kLanes) {
      const U numbers = LoadU(near.block + k + static_cast<std::uint32_t>(at));
      count += TakeSpheres(near.spheres[k / kFacetLanes], to->c, reach, numbers, at, blocks + count);
    }
  }
  for (std::uint32_t n = 0; n < count; ++n) MeetBlock(in, blocks[n], scratch, to);
  return true;
}

// First with little slack, enough for most points: few triangles are within it.
void MeasureFacets(const WalkInput& in, FacetPoints* points, std::uint32_t count, FacetScratch* scratch) {
  for (std::uint32_t k = 0; k < kFacetSlots; ++k) scratch->block[k] = 0xffffffffU;
  scratch->near.reach = 0.0f;
  for (std::uint32_t i = 0; i < count; ++i) {
    FacetTarget target{};
    FindTarget(in, points[i], &target);
    bool is_found = true;
    for (const float slack : {kUsualFieldError, kMostFieldError}) {
      StartFacets(points[i], slack, &target);
      is_found = is_found && MeetFacets(in, scratch, &target);
      unsigned open = 0;
      for (const F& squared : target.squared) open |= Bits((I)(squared == kUnmet));
      if (open == 0) break;
    }
    if (!is_found) {
      for (F& squared : target.squared) squared = Fill(kUnmet);
    }
    for (int j = 0; j < kParts; ++j) {
      const int at = j * kLanes;
      // Nearer than rounding the way has no direction.
      const F size = Length(target.away[j]);
      const F side = (target.is_beside[j] & (I)(target.height[j] < 0.0f)) ? Fill(-1.0f) : Fill(1.0f);
      const I is_known = (I)(target.squared[j] >= 0.0f) & (I)(size > 1e-4f);
      Store(Times(target.away[j], is_known ? side / size : F{}), points[i].gx + at, points[i].gy + at,
            points[i].gz + at);
      const F distance = Sqrt(Max(target.squared[j], F{}));
      const F depth = target.height[j] < 0.0f ? distance : -distance;
      StoreF(points[i].depth + at, target.squared[j] < 0.0f ? LoadF(points[i].depth + at) : depth);
    }
  }
}
