// Patches of S in G's field; included by walk_lanes.hpp. README.md derives the formulas.

void ReadPatches(const PatchInput& in, PatchBlock* b) {
  const auto& R = in.rotation;
  for (int at = 0; at < kPatchLanes; at += kLanes) {
    const Vec3 p = ToVoxels(in.field, LoadF(b->node[kCentreRow] + at), LoadF(b->node[kCentreRow + 1] + at),
                            LoadF(b->node[kCentreRow + 2] + at));
    const FieldAt field = SampleWithGradient(in.field, p);
    const Vec3& g = field.gradient;
    StoreF(b->depth + at, in.offset_m - field.distance * in.field.m_per_voxel);
    for (int i = 0; i < 3; ++i) {  // R^T g
      StoreF(b->slope[i] + at, -Fma(Fill(R[0][i]), g.x, Fma(Fill(R[1][i]), g.y, R[2][i] * g.z)));
    }
  }
}

// A symmetric matrix: xx, yy, zz, xy, xz, yz.
struct Symmetric {
  F of[6];
};
inline Symmetric LoadSymmetric(const PatchRow* rows, int at) {
  Symmetric s;
  for (int i = 0; i < 6; ++i) s.of[i] = LoadF(rows[i] + at);
  return s;
}
inline Vec3 Times(const Symmetric& s, const Vec3& v) {
  return {Fma(s.of[0], v.x, Fma(s.of[3], v.y, s.of[4] * v.z)), Fma(s.of[3], v.x, Fma(s.of[1], v.y, s.of[5] * v.z)),
          Fma(s.of[4], v.x, Fma(s.of[5], v.y, s.of[2] * v.z))};
}
inline F TraceOf(const Symmetric& s, const Symmetric& t) {
  const F across = Fma(s.of[3], t.of[3], Fma(s.of[4], t.of[4], s.of[5] * t.of[5]));
  return Fma(s.of[0], t.of[0], Fma(s.of[1], t.of[1], Fma(s.of[2], t.of[2], across + across)));
}

// How the parent's prediction differs from what was read, over each family, weighted by area.
inline void CompareWithParents(PatchBlock* b) {
  alignas(64) float missed[kPatchLanes];
  for (int at = 0; at < kPatchLanes; at += kLanes) {
    const Vec3 e{LoadF(b->node[kCentreRow] + at) - LoadF(b->parent[kModelCentre] + at),
                 LoadF(b->node[kCentreRow + 1] + at) - LoadF(b->parent[kModelCentre + 1] + at),
                 LoadF(b->node[kCentreRow + 2] + at) - LoadF(b->parent[kModelCentre + 2] + at)};
    const Vec3 slope{LoadF(b->parent[kModelSlope] + at), LoadF(b->parent[kModelSlope + 1] + at),
                     LoadF(b->parent[kModelSlope + 2] + at)};
    const F bent = Dot(e, Times(LoadSymmetric(b->parent + kModelBend, at), e));
    const F predicted = LoadF(b->parent[kModelDepth] + at) + Dot(slope, e) - 0.5f * bent;
    StoreF(missed + at, predicted - LoadF(b->depth + at));
  }
  for (int first = 0; first < kPatchLanes; first += kFamilySize) {
    float sum = 0.0f;
    float over = 0.0f;
    float under = 0.0f;
    float area = 0.0f;
    for (int k = first; k < first + kFamilySize; ++k) {
      const float a = b->node[kAreaRow][k];
      const float value = missed[k];
      sum += a * value;
      (value > 0.0f ? over : under) += a * value * value;
      area += a;
    }
    const float per = area > 0.0f ? 1.0f / area : 0.0f;
    const float mean = sum * per;
    const float over_spread = __builtin_sqrtf(over * per);
    const float under_spread = __builtin_sqrtf(under * per);
    for (int k = first; k < first + kFamilySize; ++k) {
      b->over[k] = mean > 0.0f ? mean : 0.0f;
      b->under[k] = mean < 0.0f ? -mean : 0.0f;
      b->over_spread[k] = over_spread;
      b->under_spread[k] = under_spread;
    }
  }
}

// FieldBends at p [voxels] for patches that reach so far [voxels], turned to S. has: lanes that have one.
struct BendAt {
  Symmetric mean;  // 1/m
  F most, least;   // 1/m; least as -least
  I has;
};
inline BendAt FindBend(const PatchInput& in, const Vec3& p, F reach) {
  const Vec3 q = ClampToGrid(in.field, p);
  // The least power of two that is not below: the exponent of the next smaller float, plus one.
  I shift = (((I)Max(reach, Fill(kLeastBendLength)) - 1) >> 23) - 126;
  const I is_known = shift <= in.num_bend_levels;
  shift = is_known ? shift : I{} + 1;
  const I last = ((I{} + 1) << shift) - 1;
  const I nx = (in.field.nx + last) >> shift;
  const I ny = (in.field.ny + last) >> shift;
  const U begin = Gather(in.bend_begin, (U)(shift - 1));
  const U cell = begin + (U)(((ToI(q.z) >> shift) * ny + (ToI(q.y) >> shift)) * nx + (ToI(q.x) >> shift));
  const U number = Gather(in.bend_numbers, cell);
  BendAt bend;
  bend.has = is_known & (I)(number != 0);
  const U at = (number - (U)(number != 0 ? U{} + 1 : U{})) * 4;
  const U w0 = Gather(in.bend_cells, at);
  const U w1 = Gather(in.bend_cells + 1, at);
  const U w2 = Gather(in.bend_cells + 2, at);
  const U w3 = Gather(in.bend_cells + 3, at);
  const auto high = [](U w) { return ToF((I)w >> 16); };
  const auto low = [](U w) { return ToF((I)(w << 16) >> 16); };
  // kBendStep / 2^shift, in 1/m.
  const F per_h = (F)(((I)Fill(1.0f)) - (shift << 23));
  const F step = bend.has ? per_h * (kBendStep * in.field.voxels_per_m) : F{};
  const F H[6] = {low(w0) * step, high(w0) * step, low(w1) * step, high(w1) * step, low(w2) * step, high(w2) * step};
  bend.most = low(w3) * (2.0f * step);
  bend.least = high(w3) * (2.0f * step);
  // R^T H R.
  const auto& R = in.rotation;
  Vec3 HR[3];
  for (int j = 0; j < 3; ++j) {
    HR[j] = Times(Symmetric{{H[0], H[1], H[2], H[3], H[4], H[5]}}, {Fill(R[0][j]), Fill(R[1][j]), Fill(R[2][j])});
  }
  const auto entry = [&](int i, int j) {
    return Fma(Fill(R[0][i]), HR[j].x, Fma(Fill(R[1][i]), HR[j].y, R[2][i] * HR[j].z));
  };
  bend.mean = {{entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)}};
  return bend;
}

// Of a triangle whose depth is d + g . e, the positive part exactly. Its corners e_i have the depths d_i. Where their
// signs differ, one corner o is alone on its side; the surface cuts its two sides at t_a = d_o / (d_o - d_a) and t_b of
// them, and of the piece around it, f = t_a t_b of the area, with corners e_o, q_a, q_b and depths d_o, 0, 0:
//
//   mean of d = f d_o / 3,   of d^2 = f d_o^2 / 6,   of d e = f d_o / 12 (2 e_o + q_a + q_b).
//
// Those are the positive part if d_o > 0, else what is to be taken off the whole.
struct FlatIntegral {
  F mean, square, most;
  Vec3 first;  // mean of max(d, 0) e
};
inline FlatIntegral IntegrateTriangles(const PatchBlock& b, int at, F d, const Vec3& g, const Vec3& Qg, F variance,
                                       F area) {
  const auto corner = [&](int i) {
    return Vec3{LoadF(b.corners[3 * i] + at), LoadF(b.corners[3 * i + 1] + at), LoadF(b.corners[3 * i + 2] + at)};
  };
  const Vec3 e1 = corner(0);
  const Vec3 e2 = corner(1);
  const Vec3 e0{-(e1.x + e2.x), -(e1.y + e2.y), -(e1.z + e2.z)};
  const F d0 = d + Dot(g, e0);
  const F d1 = d + Dot(g, e1);
  const F d2 = d + Dot(g, e2);
  const I p0 = d0 > 0.0f;
  const I p1 = d1 > 0.0f;
  const I p2 = d2 > 0.0f;
  const I is_0 = (p0 ^ p1) & (p0 ^ p2);
  const I is_1 = (p1 ^ p0) & (p1 ^ p2);
  const I is_cut = (p0 ^ p1) | (p0 ^ p2);
  const auto pick = [&](const Vec3& a, const Vec3& c, const Vec3& otherwise) {
    return Vec3{is_0 ? a.x : (is_1 ? c.x : otherwise.x), is_0 ? a.y : (is_1 ? c.y : otherwise.y),
                is_0 ? a.z : (is_1 ? c.z : otherwise.z)};
  };
  const F d_o = is_0 ? d0 : (is_1 ? d1 : d2);
  const F d_a = is_0 ? d1 : (is_1 ? d2 : d0);
  const F d_b = is_0 ? d2 : (is_1 ? d0 : d1);
  const Vec3 o = pick(e0, e1, e2);
  const Vec3 a = pick(e1, e2, e0);
  const Vec3 c = pick(e2, e0, e1);
  const F t_a = is_cut ? d_o / (d_o - d_a) : F{};
  const F t_b = is_cut ? d_o / (d_o - d_b) : F{};
  const F f = t_a * t_b;
  const F mean = f * d_o * (1.0f / 3.0f);
  const F square = f * d_o * d_o * (1.0f / 6.0f);
  const F twelfth = f * d_o * (1.0f / 12.0f);
  const auto first = [&](F eo, F ea, F ec) { return twelfth * (4.0f * eo + t_a * (ea - eo) + t_b * (ec - eo)); };
  const Vec3 part{first(o.x, a.x, c.x), first(o.y, a.y, c.y), first(o.z, a.z, c.z)};
  const F whole = (p0 & p1) | (p0 & p2) | (p1 & p2) ? Fill(1.0f) : F{};  // two or three corners are inside
  const F sign = whole > 0.5f ? Fill(-1.0f) : Fill(1.0f);
  const F per_area = whole / area;
  FlatIntegral out;
  out.mean = Max(Fma(whole, d, sign * mean), F{});
  out.square = Max(Fma(whole, Fma(d, d, variance), sign * square), F{});
  out.first = {Fma(per_area, Qg.x, sign * part.x), Fma(per_area, Qg.y, sign * part.y),
               Fma(per_area, Qg.z, sign * part.z)};
  out.most = Max(d0, Max(d1, d2));
  return out;
}

// The depth over a patch, by its mean: with the part g_t of the slope along the patch, that across it, c = g . n, and
// M = c K - H,
//   depth - mean = g_t . e + 1/2 (e^T M e - tr(M Q) / a).
// Of surfaces that conform M is 0: they bend alike.
struct DepthModel {
  Vec3 along;  // g_t
  Symmetric M;
  F variance;  // g_t^T Q g_t / a + 1/2 tr((M Q / a)^2), that of a Gaussian spread
  F reach;     // |depth - mean| at any place: |g_t| r + 1/2 |M| r^2 + |c| t, no more than r
};
inline DepthModel ModelOf(const PatchBlock& b, int at, const Vec3& g, const Symmetric& H, const Symmetric& Q,
                          F per_area) {
  const Vec3 A{LoadF(b.node[kAreaVectorRow] + at), LoadF(b.node[kAreaVectorRow + 1] + at),
               LoadF(b.node[kAreaVectorRow + 2] + at)};
  const F per_length = 1.0f / Max(Length(A), Fill(1e-30f));
  const Vec3 n{A.x * per_length, A.y * per_length, A.z * per_length};
  const F c = Dot(g, n);
  DepthModel model;
  model.along = {Fma(-c, n.x, g.x), Fma(-c, n.y, g.y), Fma(-c, n.z, g.z)};
  const Symmetric K = LoadSymmetric(b.node + kCurvatureRow, at);
  for (int i = 0; i < 6; ++i) model.M.of[i] = Fma(c, K.of[i], -H.of[i]);
  // M Q / a column by column: M times the columns of Q.
  const Vec3 columns[3] = {{Q.of[0], Q.of[3], Q.of[4]}, {Q.of[3], Q.of[1], Q.of[5]}, {Q.of[4], Q.of[5], Q.of[2]}};
  const Vec3 x = Times(model.M, columns[0]);
  const Vec3 y = Times(model.M, columns[1]);
  const Vec3 z = Times(model.M, columns[2]);
  const F diagonal = Fma(x.x, x.x, Fma(y.y, y.y, z.z * z.z));
  const F square = Fma(Fill(2.0f), Fma(x.y, y.x, Fma(x.z, z.x, y.z * z.y)), diagonal) * (per_area * per_area);
  const F linear = Dot(model.along, Times(Q, model.along)) * per_area;
  model.variance = Max(Fma(Fill(0.5f), square, linear), F{});
  const F radius = LoadF(b.node[kRadiusRow] + at);
  const F size = Sqrt(TraceOf(model.M, model.M));
  const F bent = Fma(Fill(0.5f) * size * radius, radius, Abs(c) * LoadF(b.node[kThicknessRow] + at));
  model.reach = Min(Fma(Length(model.along), radius, bent), radius);
  return model;
}

// The integral over patches whose depth is d in the mean and has the slope g (README.md, closed form).
struct PatchIntegral {
  F mean, square;
  F most;  // greatest depth by the model
  Vec3 force, moment;
  Vec3 Qg;
};
inline PatchIntegral IntegratePatches(const PatchBlock& b, int at, F d, const Vec3& slope, const Symmetric& Q,
                                      const DepthModel& model) {
  PatchIntegral out;
  const F area = LoadF(b.node[kAreaRow] + at);
  const Vec3& g = model.along;
  out.Qg = Times(Q, g);
  const F w = Max(Min(model.reach, Sqrt(3.0f * model.variance)), Fill(1e-12f));
  const I is_inside = d >= w;
  const I is_cut = ~is_inside & (I)(d > -w);
  const F u = d + w;
  const F per_w = 1.0f / w;
  out.mean = is_inside ? d : (is_cut ? 0.25f * u * u * per_w : F{});
  out.square = is_inside ? Fma(d, d, w * w * (1.0f / 3.0f)) : (is_cut ? u * u * u * per_w * (1.0f / 6.0f) : F{});
  // (d w^2 / 2 + w^3 / 3 - d^3 / 6) / (2 w^3 / 3) with t = d / w.
  const F t = d * per_w;
  const F share = is_inside ? Fill(1.0f) : (is_cut ? Fma(t, Fma(t * t, Fill(-0.25f), Fill(0.75f)), Fill(0.5f)) : F{});
  const Vec3 A{LoadF(b.node[kAreaVectorRow] + at), LoadF(b.node[kAreaVectorRow + 1] + at),
               LoadF(b.node[kAreaVectorRow + 2] + at)};
  const auto N = [&](int column) {
    const PatchRow* const rows = b.node + kNormalMomentRow + 3 * column;
    return Vec3{LoadF(rows[0] + at), LoadF(rows[1] + at), LoadF(rows[2] + at)};
  };
  const Vec3 Nx = N(0);
  const Vec3 Ny = N(1);
  const Vec3 Nz = N(2);
  // With all of the slope: N n is 0 of what bends evenly, where K and H count instead, but not where faces meet.
  const Vec3 Ng{Fma(Nx.x, slope.x, Fma(Ny.x, slope.y, Nz.x * slope.z)),
                Fma(Nx.y, slope.x, Fma(Ny.y, slope.y, Nz.y * slope.z)),
                Fma(Nx.z, slope.x, Fma(Ny.z, slope.y, Nz.z * slope.z))};
  out.force = {Fma(A.x, out.mean, share * Ng.x), Fma(A.y, out.mean, share * Ng.y), Fma(A.z, out.mean, share * Ng.z)};
  // Of n times the first moment of the depth.
  const F per_length = share / Max(Length(A), Fill(1e-30f));
  const Vec3 of_node = Cross(out.Qg, A);
  Vec3 turned{of_node.x * per_length, of_node.y * per_length, of_node.z * per_length};
  out.most = d + w;
  const I is_flat = LoadF(b.node[kIsFlatRow] + at) > 0.5f;
  if (Bits(is_flat) != 0) {
    const Vec3 Qg = Times(Q, slope);
    const F variance = Max(Dot(slope, Qg) / area, F{});
    const FlatIntegral flat = IntegrateTriangles(b, at, d, slope, Qg, variance, area);
    out.mean = is_flat ? flat.mean : out.mean;
    out.square = is_flat ? flat.square : out.square;
    out.most = is_flat ? flat.most : out.most;
    const Vec3 of_flat = Cross(flat.first, A);
    turned = {is_flat ? of_flat.x : turned.x, is_flat ? of_flat.y : turned.y, is_flat ? of_flat.z : turned.z};
    out.force = {is_flat ? A.x * flat.mean : out.force.x, is_flat ? A.y * flat.mean : out.force.y,
                 is_flat ? A.z * flat.mean : out.force.z};
  }
  const Vec3 c{LoadF(b.node[kCentreRow] + at), LoadF(b.node[kCentreRow + 1] + at), LoadF(b.node[kCentreRow + 2] + at)};
  const Vec3 lever = Cross(c, out.force);
  out.moment = {lever.x + Fma(Ny.z - Nz.y, out.mean, turned.x), lever.y + Fma(Nz.x - Nx.z, out.mean, turned.y),
                lever.z + Fma(Nx.y - Ny.x, out.mean, turned.z)};
  return out;
}

inline void AddTo(double* sums, F values, int at) {
  alignas(64) float of[kLanes];
  StoreF(of, values);
  for (int k = 0; k < kLanes; ++k) sums[at + k] += static_cast<double>(of[k]);
}

inline void AddSquaresTo(double* sums, F values, int at) {
  alignas(64) float of[kLanes];
  StoreF(of, values);
  for (int k = 0; k < kLanes; ++k) sums[at + k] += static_cast<double>(of[k]) * static_cast<double>(of[k]);
}

void JudgePatches(const PatchInput& in, PatchBlock* b, PatchSums* sums) {
  if (b->has_parent) CompareWithParents(b);
  const float voxel_m = in.field.m_per_voxel;
  b->open = b->read_exactly = b->touches = b->counts = 0;
  for (int at = 0; at < kPatchLanes; at += kLanes) {
    const F area = LoadF(b->node[kAreaRow] + at);
    const F radius = LoadF(b->node[kRadiusRow] + at);
    const F read = LoadF(b->depth + at);
    const Vec3 slope{LoadF(b->slope[0] + at), LoadF(b->slope[1] + at), LoadF(b->slope[2] + at)};
    const Vec3 p = ToVoxels(in.field, LoadF(b->node[kCentreRow] + at), LoadF(b->node[kCentreRow + 1] + at),
                            LoadF(b->node[kCentreRow + 2] + at));
    const F reach = radius * in.field.voxels_per_m;
    const BendAt bend = FindBend(in, p, Max(reach, Abs(read) * in.field.voxels_per_m));
    const Symmetric Q = LoadSymmetric(b->node + kSpreadRow, at);
    const F per_area = 1.0f / area;
    // Mean depth over the patch, and a bound of how far that may be off.
    const F correction = -0.5f * TraceOf(bend.mean, Q) * per_area;
    const F spread_voxels = 0.5f * (Q.of[0] + Q.of[1] + Q.of[2]) * per_area;
    // Below the least length it is edges that bend, and an edge misses in proportion to the size, not to its square.
    const F per_reach = reach < kLeastBendLength ? kLeastBendLength / Max(reach, Fill(0.05f)) : Fill(1.0f);
    const auto bound = [&](F second) {
      return bend.has ? Min(second * spread_voxels * per_reach, 2.0f * radius) : radius;
    };
    const F bent_down = bound(bend.most);
    const F bent_up = bound(bend.least);
    const F depth = read > -radius ? Max(read + correction, -radius) : read;
    const DepthModel model = ModelOf(*b, at, slope, bend.mean, Q, per_area);
    const PatchIntegral integral = IntegratePatches(*b, at, depth, slope, Q, model);

    // The depth may be less than the model's by `down` and more by `up`. Of max(depth, 0) no more than all can be
    // missing.
    const F over = LoadF(b->over + at);
    const I is_tested = over >= 0.0f;
    const auto off = [&](F missed, F bent) {
      return is_tested ? Min(Fma(Fill(kMissed), missed, kUnseenBend * bent), radius + radius) : bent;
    };
    // Of the correction itself a part is in doubt: its mean is that of a cell.
    const F down = off(over, bent_down) + kUnsure * Max(correction, F{});
    const F up = off(LoadF(b->under + at), bent_up) + kUnsure * Max(-correction, F{});
    // The field's error at the surface; farther inside it is small against the depth.
    const Vec3 q = ClampToGrid(in.field, p);
    const U brick =
        (U)(((ToI(q.z) >> 3) * (in.field.ny >> 3) + (ToI(q.y) >> 3)) * (in.field.nx >> 3) + (ToI(q.x) >> 3));
    const I is_exact = LoadF(b->exact + at) > 0.5f;
    F known{};
    F blur{};
    if (Bits(~is_exact) != 0) {
      const F at_surface = Max((F)Gather(in.brick_errors, brick), Fill(kLeastFieldError)) * voxel_m;
      known = ~is_exact & (I)(Abs(depth) < kDeepestExact * voxel_m) ? at_surface : F{};
      blur = Fma(Fill(kSlopeError), radius, known + known);
    }
    // The greatest depth is above the mean by at most the radius, and by the model's reach. A large patch may have
    // parts of G near that its centre does not see: what the field may bend up to its rim, 1/2 bend.least r^2,
    // counts there.
    const Vec3 A{LoadF(b->node[kAreaVectorRow] + at), LoadF(b->node[kAreaVectorRow + 1] + at),
                 LoadF(b->node[kAreaVectorRow + 2] + at)};
    const I is_flat = LoadF(b->node[kIsFlatRow] + at) > 0.5f;
    const I is_small = (I)(reach < kLeastBendLength);
    const F half_square = 0.5f * radius * radius;
    const F by_model = is_flat & is_small ? integral.most - depth : model.reach;
    const F bent_to_rim = bend.has ? half_square * bend.least : radius;
    const F cut = Max(Min(is_small ? by_model : by_model + bent_to_rim, radius), Fill(1e-12f));
    // A small patch lies by its corners, and what the field bends in the mean is added. Where G's triangles were read
    // they may turn within it: so are the bound, and what the parent mispredicted at the family, since a rim is about
    // as far from its centre as that is from the parent's. A miss in the mean keeps its sign at the next scale, how the
    // family scatters around it does not.
    const F over_spread = LoadF(b->over_spread + at);
    const F under_spread = LoadF(b->under_spread + at);
    F beyond = is_small ? half_square * Sqrt(TraceOf(bend.mean, bend.mean)) : F{};
    F scatter{};
    if (Bits(is_exact) != 0) {
      const F missed = over - LoadF(b->under + at);
      const F square = is_exact & is_tested ? Fma(over_spread, over_spread, under_spread * under_spread) : F{};
      beyond += Sqrt(square) + (is_exact & is_small ? per_reach * bent_to_rim : F{});
      scatter = Sqrt(Max(square - missed * missed, F{}));
    }
    const F to_rim = Min(cut + beyond, radius) + up + blur;
    const F inside = Max(Min(Fma(Fill(0.5f), Max(depth, read) / to_rim, Fill(0.5f)), Fill(1.0f)), F{});
    const F inside_area = area * inside;
    F bias = Fma(inside_area, up, area * Min(down, integral.mean));
    const F spread_up = is_tested ? inside * (kMissed * Max(under_spread, scatter)) : F{};
    const F spread_down = is_tested ? Min(kMissed * over_spread, integral.mean) : F{};
    F variance_m2 = Fma(spread_up, spread_up, spread_down * spread_down);  // of the mean depth over the patch
    // Where the two sides of a plate are all of it, its depths are at the ends of their range.
    const F near_cut = inside > 0.0f ? Max(1.0f - Abs(depth) / radius, F{}) : F{};
    const F curved = Max(1.0f - Length(A) * per_area, F{});
    const F by_cut = is_flat ? F{} : (curved + kStraddling) * cut * near_cut * near_cut;
    variance_m2 = Fma(by_cut, by_cut, variance_m2);
    // The field's own error: its mean is of one sign, the rest is drawn anew in each voxel. Deep inside, that of coarse
    // cells.
    F field_error{};  // in the mean
    F field_share{};
    const F area_per_deviation = area * in.per_deviation;
    if (Bits(~is_exact) != 0) {
      const I is_deep = ~is_exact & (I)(depth > kDeepestExact * voxel_m);
      const F inner = is_deep ? (F)Gather(in.inner_errors, brick) * voxel_m : F{};
      field_error = Fma(Fill(kMeanOfFieldError), known, kMeanOfInnerError * inner);
      const F field_bias = field_error * inside_area;
      const F field_variance_m2 = known * known * inside * (voxel_m * voxel_m * per_area);
      bias += field_bias;
      variance_m2 += field_variance_m2;
      field_share = Fma(area * field_variance_m2, area_per_deviation, field_bias);
    }
    const F share = Fma(area * variance_m2, area_per_deviation, bias);
    const F deviation = area * Sqrt(variance_m2);

    const I is_part = area > 0.0f;
    const I touches = is_part & (I)(integral.mean > 0.0f);
    const I is_large = is_part & (I)(radius > in.least_radius_m) & (I)(share > in.threshold_m3);
    // The field is not good enough there, nor in parts of it, and by triangles it would be kept.
    const I is_fine = (I)(share - field_share <= in.threshold_m3);
    const I is_rough = b->is_asked ? I{} : touches & is_fine & (I)(field_error > in.most_field_error_m);
    const I opens = is_large | is_rough;
    const I is_kept = is_part & ~opens;
    // The larger of two errors is reduced: the field's own by its triangles, else the patch's by opening it.
    b->open |= Bits(opens) << at;
    b->read_exactly |= Bits(is_rough | (is_large & (I)(field_share > 0.5f * share))) << at;
    b->touches |= Bits(touches) << at;
    b->counts |= Bits(is_kept & (touches | (I)(share > 0.0f))) << at;

    for (int i = 0; i < 6; ++i) StoreF(b->bend[i] + at, bend.mean.of[i]);
    const F* const force[3] = {&integral.force.x, &integral.force.y, &integral.force.z};
    const F* const moment[3] = {&integral.moment.x, &integral.moment.y, &integral.moment.z};
    const F volume = area * integral.mean;
    const F square = area * integral.square;
    const F zero{};
    for (int i = 0; i < 3; ++i) {
      StoreF(b->force[i] + at, *force[i]);
      StoreF(b->moment[i] + at, *moment[i]);
      AddTo(sums->of[PatchSums::kFx + i], is_kept ? *force[i] : zero, at);
      AddTo(sums->of[PatchSums::kMx + i], is_kept ? *moment[i] : zero, at);
    }
    StoreF(b->volume + at, volume);
    StoreF(b->square + at, square);
    StoreF(b->bias + at, bias);
    StoreF(b->deviation + at, deviation);
    StoreF(b->support + at, integral.most);
    AddTo(sums->of[PatchSums::kVolume], is_kept ? volume : zero, at);
    AddTo(sums->of[PatchSums::kSquare], is_kept ? square : zero, at);
    AddTo(sums->of[PatchSums::kBias], is_kept ? bias : zero, at);
    // Of an exact depth its rounding stays.
    const F lasting = voxel_m * kRounding * inside_area;
    AddTo(sums->of[PatchSums::kLasting], is_kept & touches ? lasting : zero, at);
    AddSquaresTo(sums->of[PatchSums::kVariance], is_kept ? deviation : zero, at);
  }
}
