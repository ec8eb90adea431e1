#include "vps/multibody/small_contact.hpp"

#include <algorithm>
#include <cmath>

#include "vps/multibody/block_sums.hpp"

namespace vps {
namespace {

// Exact places of a contact: between so many and twice as many (decision 16).
constexpr double kFewestPlaces = 130.0;
// Area of a quarter of a piece over the square of the longest side allowed. Halving leaves sides between 0.7 and 1 of
// that length, and a piece with the longest side l has about 0.25 to 0.4 l^2: about 0.2 in the mean, a quarter of it.
constexpr double kQuarter = 0.05;
constexpr double kFinest = 0.25;  // of the samples' spacing; that of the finer points
// Where there are too many pieces of a size, twice as large ones are tried, up to twice those that S is cut to.
constexpr double kCoarser = 2.0;
constexpr double kCoarsest = 8.0;
// Sizes differ by a factor of sqrt(2); over this share of the way from one to the next both are used and blended. Not
// derived: a wider blend takes time, a narrower one makes the force steeper there.
constexpr double kBlend = 0.1;
// Bounds for culling, not derived: deviation of the depth from its linear variation over a piece, times the square of
// half the side in voxels [1/voxel]; and steps of the field from cell to cell [voxels].
constexpr float kBending = 0.25f;
constexpr float kCellSteps = 0.02f;

constexpr std::uint32_t kAtOnce = 4;  // lanes of an F4

// The sixteen places of a piece, in barycentric coordinates u, v (shares of the sides from corner 0 to 1 and to 2): of
// each quarter its centroid, then those of its own quarters at the corners.
struct Places {
  float u[kBlock], v[kBlock];
};
constexpr Places MakePlaces() {
  constexpr float corners[4][3][2] = {{{0, 0}, {0.5, 0}, {0, 0.5}},
                                      {{0.5, 0}, {1, 0}, {0.5, 0.5}},
                                      {{0, 0.5}, {0.5, 0.5}, {0, 1}},
                                      {{0.5, 0.5}, {0, 0.5}, {0.5, 0}}};
  Places places{};
  for (std::uint32_t q = 0; q < 4; ++q) {
    const float middle_u = (corners[q][0][0] + corners[q][1][0] + corners[q][2][0]) / 3.0f;
    const float middle_v = (corners[q][0][1] + corners[q][1][1] + corners[q][2][1]) / 3.0f;
    places.u[4 * q] = middle_u;
    places.v[4 * q] = middle_v;
    for (std::uint32_t k = 0; k < 3; ++k) {
      places.u[4 * q + 1 + k] = 0.5f * (middle_u + corners[q][k][0]);
      places.v[4 * q + 1 + k] = 0.5f * (middle_v + corners[q][k][1]);
    }
  }
  return places;
}
constexpr Places kPlaces = MakePlaces();

F4 Positive(const F4& v) {
  return v > 0.0f ? v : F4{};
}
F4 Greater(const F4& a, const F4& b) {
  return a > b ? a : b;
}
F4 Less(const F4& a, const F4& b) {
  return a < b ? a : b;
}
float LargestLane(const F4& v) {
  return std::max(std::max(v[0], v[1]), std::max(v[2], v[3]));
}

// A corner, or a difference of corners, of four triangles.
struct Corners {
  F4 x, y, z;
};
Corners Load(const SmallContact::Triangles& triangles, std::uint32_t corner, std::uint32_t i) {
  return {LoadF4(&triangles.of[3 * corner][i]), LoadF4(&triangles.of[3 * corner + 1][i]),
          LoadF4(&triangles.of[3 * corner + 2][i])};
}
Corners operator-(const Corners& a, const Corners& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
F4 Dot(const Corners& a, const Corners& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
Corners MiddleOf(const Corners& a, const Corners& b, const Corners& c) {
  constexpr float kThird = 1.0f / 3.0f;
  return {(a.x + b.x + c.x) * kThird, (a.y + b.y + c.y) * kThird, (a.z + b.z + c.z) * kThird};
}

using Corner = std::array<float, 3>;
Corner CornerOf(const SmallContact::Triangles& triangles, std::int32_t corner, std::uint32_t i) {
  const auto at = static_cast<std::size_t>(3 * corner);
  return {triangles.of[at][i], triangles.of[at + 1][i], triangles.of[at + 2][i]};
}
void Append(const Corner& a, const Corner& b, const Corner& c, SmallContact::Triangles* to) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    to->of[axis][to->count] = a[axis];
    to->of[3 + axis][to->count] = b[axis];
    to->of[6 + axis][to->count] = c[axis];
  }
  ++to->count;
}

// Fills up to whole registers with the last one.
void FillUp(SmallContact::Triangles* triangles) {
  const std::uint32_t n = triangles->count;
  for (std::vector<float>& coordinate : triangles->of) {
    for (std::uint32_t i = n; i % kAtOnce != 0; ++i) coordinate[i] = coordinate[n - 1];
  }
}

// Number on a Morton curve through cells of half a voxel; periodic with 512 voxels.
std::uint32_t PlaceInCurve(const glm::vec3& p, double voxel_m) {
  std::uint32_t place = 0;
  const auto per_m = static_cast<float>(2.0 / voxel_m);
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    auto bits =
        static_cast<std::uint32_t>(static_cast<std::int32_t>(p[static_cast<int>(axis)] * per_m) + 0x8000) & 0x3ffU;
    bits = (bits | bits << 16) & 0x030000ffU;
    bits = (bits | bits << 8) & 0x0300f00fU;
    bits = (bits | bits << 4) & 0x030c30c3U;
    bits = (bits | bits << 2) & 0x09249249U;
    place |= bits << axis;
  }
  return place;
}

}  // namespace

SmallContact::Triangles::Triangles() {
  for (std::vector<float>& coordinate : of) coordinate.resize(kMost + kAtOnce);
}

SmallContact::SmallContact()
    : queue_(Triangles::kMost),
      next_queue_(Triangles::kMost),
      sides_m2_(Triangles::kMost + kAtOnce),
      longest_(Triangles::kMost + kAtOnce),
      order_(kMostBlocksAtOnce),
      inwards_(kMostBlocksAtOnce + kAtOnce),
      points_(kMostBlocksAtOnce),
      spheres_((kMostBlocksAtOnce + kBlock - 1) / kBlock),
      depths_(kMostBlocksAtOnce),
      exact_(kMostBlocksAtOnce),
      patches_(kMostPatches) {}

// The pieces that may be inside, from the tree.
bool SmallContact::FindCandidates(const SurfacePieces& S, SphereSieve* sieve) {
  std::uint32_t size = 1;
  queue_[0] = 0;
  for (std::uint32_t level = S.num_levels; level-- > 0;) {
    std::uint32_t num_next = 0;
    for (std::uint32_t i = 0; i < size; ++i) {
      const SphereBlock& block = S.spheres[S.level_begin[level] + queue_[i]];
      for (unsigned lanes = sieve->MayBeInside(block); lanes != 0; lanes &= lanes - 1) {
        if (num_next == Triangles::kMost) return false;
        next_queue_[num_next++] = queue_[i] * kBlock + static_cast<std::uint32_t>(__builtin_ctz(lanes));
      }
    }
    queue_.swap(next_queue_);
    size = num_next;
  }
  num_found_ = size;
  return true;
}

// As the candidates to be divided.
void SmallContact::TakeFound(const SurfacePieces& S) {
  candidates_.count = 0;
  for (std::uint32_t i = 0; i < num_found_; ++i) {
    const auto& [a, b, c] = S.pieces[queue_[i]].corners;
    Append({a.x, a.y, a.z}, {b.x, b.y, b.z}, {c.x, c.y, c.z}, &candidates_);
  }
}

// The middle and the corners of four candidates to a block, and their longest sides.
void SmallContact::PlaceOnCandidates() {
  FillUp(&candidates_);
  for (std::uint32_t i = 0; i < candidates_.count; i += kAtOnce) {
    const Corners corners[3] = {Load(candidates_, 0, i), Load(candidates_, 1, i), Load(candidates_, 2, i)};
    const Corners middle = MiddleOf(corners[0], corners[1], corners[2]);
    PointBlock& block = points_[i / kAtOnce];
    SphereBlock& spheres = spheres_[i / kAtOnce / kBlock];
    const std::uint32_t lane = i / kAtOnce % kBlock;
    spheres.x[lane] = middle.x[0];
    spheres.y[lane] = middle.y[0];
    spheres.z[lane] = middle.z[0];
    const Corners centre{F4{} + middle.x[0], F4{} + middle.y[0], F4{} + middle.z[0]};
    F4 reach_m2{};
    for (std::uint32_t k = 0; k < 4; ++k) {
      const Corners& p = k == 0 ? middle : corners[k - 1];
      StoreF4(block.x + k * kAtOnce, p.x);
      StoreF4(block.y + k * kAtOnce, p.y);
      StoreF4(block.z + k * kAtOnce, p.z);
      reach_m2 = Greater(reach_m2, Dot(p - centre, p - centre));
    }
    std::fill_n(block.area_m2, kBlock, 0.0f);
    spheres.r[lane] = std::sqrt(LargestLane(reach_m2));
    F4 longest_m2{};
    I4 at{};
    for (std::int32_t k = 0; k < 3; ++k) {
      const Corners side = corners[(k + 1) % 3] - corners[k];
      const F4 side_m2 = Dot(side, side);
      at = side_m2 > longest_m2 ? I4{} + k : at;
      longest_m2 = Greater(longest_m2, side_m2);
    }
    StoreF4(&sides_m2_[i], longest_m2);
    std::memcpy(&longest_[i], &at, sizeof at);
  }
}

// Candidates that may be inside become pieces where they are small enough, else two candidates of the next round.
// Between the tested places the depth rises by at most its variation plus a term for curvature, and in any case by no
// more than the distance to the nearest tested place (half the longest side):
//   rise = min((largest - least) / 4 + kBending l^2 / 4, l / 2)   with the longest side l in voxels.
bool SmallContact::SortCandidates(float longest_m, float voxel_m) {
  halves_.count = 0;
  for (std::uint32_t i = 0; i < candidates_.count; i += kAtOnce) {
    const float* const of = depths_[i / kAtOnce].of;
    const F4 d[4] = {LoadF4(of), LoadF4(of + 4), LoadF4(of + 8), LoadF4(of + 12)};
    const F4 most = Greater(Greater(d[0], d[1]), Greater(d[2], d[3]));
    const F4 least = Less(Less(d[0], d[1]), Less(d[2], d[3]));
    const F4 side_m2 = LoadF4(&sides_m2_[i]);
    const F4 way2 = side_m2 * (0.25f / (voxel_m * voxel_m));
    const F4 rise = 0.25f * (most - least) + kBending * way2;
    const F4 free = -(most + (kExactOutside + kCellSteps));
    const I4 is_apart = (free > rise) | ((free > 0.0f) & (free * free > way2));
    for (std::uint32_t j = 0; j < std::min(kAtOnce, candidates_.count - i); ++j) {
      if (is_apart[j] != 0) continue;
      const std::int32_t k = longest_[i + j];
      const Corner a = CornerOf(candidates_, k, i + j);
      const Corner b = CornerOf(candidates_, (k + 1) % 3, i + j);
      const Corner c = CornerOf(candidates_, (k + 2) % 3, i + j);
      if (side_m2[j] <= longest_m * longest_m) {
        if (pieces_.count == kMostBlocksAtOnce) return false;
        Append(a, b, c, &pieces_);
        continue;
      }
      if (halves_.count + 2 > Triangles::kMost) return false;
      const Corner middle{0.5f * (a[0] + b[0]), 0.5f * (a[1] + b[1]), 0.5f * (a[2] + b[2])};
      Append(a, middle, c, &halves_);
      Append(middle, b, c, &halves_);
    }
  }
  return true;
}

bool SmallContact::Divide(float longest_m, const DistanceField& field, const core::Pose& X_GS) {
  pieces_.count = 0;
  while (candidates_.count > 0) {
    PlaceOnCandidates();
    FindDepths(points_.data(), spheres_.data(), (candidates_.count + kAtOnce - 1) / kAtOnce, field, X_GS,
               depths_.data());
    if (!SortCandidates(longest_m, static_cast<float>(field.voxel_size_m))) return false;
    std::swap(candidates_, halves_);
  }
  return true;
}

// Sixteen places to a block, with spheres and normals.
void SmallContact::PlaceOnPieces() {
  FillUp(&pieces_);
  for (std::uint32_t i = 0; i < pieces_.count; i += kAtOnce) {
    const Corners a = Load(pieces_, 0, i);
    const Corners b = Load(pieces_, 1, i);
    const Corners c = Load(pieces_, 2, i);
    const Corners middle = MiddleOf(a, b, c);
    const F4 reach_m2 =
        Greater(Dot(a - middle, a - middle), Greater(Dot(b - middle, b - middle), Dot(c - middle, c - middle)));
    const Corners u = b - a;
    const Corners v = c - a;
    const Corners n{v.y * u.z - v.z * u.y, v.z * u.x - v.x * u.z, v.x * u.y - v.y * u.x};
    const F4 n2 = Dot(n, n);
    for (std::uint32_t j = 0; j < std::min(kAtOnce, pieces_.count - i); ++j) {
      const std::uint32_t at = i + j;
      SphereBlock& spheres = spheres_[at / kBlock];
      spheres.x[at % kBlock] = middle.x[j];
      spheres.y[at % kBlock] = middle.y[j];
      spheres.z[at % kBlock] = middle.z[j];
      spheres.r[at % kBlock] = std::sqrt(reach_m2[j]);
      const float length = std::sqrt(n2[j]);
      inwards_[at] = length > 0.0f ? glm::vec3(n.x[j], n.y[j], n.z[j]) / length : glm::vec3(0.0f);
      PointBlock& block = points_[at];
      for (std::uint32_t k = 0; k < kBlock; k += kAtOnce) {
        const F4 to_b = LoadF4(kPlaces.u + k);
        const F4 to_c = LoadF4(kPlaces.v + k);
        StoreF4(block.x + k, a.x[j] + (to_b * u.x[j] + to_c * v.x[j]));
        StoreF4(block.y + k, a.y[j] + (to_b * u.y[j] + to_c * v.y[j]));
        StoreF4(block.z + k, a.z[j] + (to_b * u.z[j] + to_c * v.z[j]));
        StoreF4(block.area_m2 + k, F4{} + length * (0.5f / kBlock));
      }
    }
  }
}

void SmallContact::FindDepthsOfPieces(const DistanceField& field, const core::Pose& X_GS, float exact_share) {
  PlaceOnPieces();
  FindDepths(points_.data(), spheres_.data(), pieces_.count, field, X_GS, depths_.data());
  std::copy_n(depths_.begin(), pieces_.count, exact_.begin());
  if (field.facets.blocks.empty() || !(exact_share > 0.0f)) return;
  // Neighbours share registers; the closer they are, the fewer facets have to be tested for them.
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < pieces_.count; ++i) {
    const float* const d = depths_[i].of;
    const float share =
        std::max(std::max(ShareOfExact(d[0]), ShareOfExact(d[4])), std::max(ShareOfExact(d[8]), ShareOfExact(d[12])));
    if (share > 0.0f) order_[count++] = {PlaceInCurve(PointOf(points_[i], 0), field.voxel_size_m), i};
  }
  std::sort(order_.begin(), order_.begin() + count);
  exact_depths_.Begin(field, X_GS, exact_share, exact_.data());
  for (std::uint32_t j = 0; j < count; ++j) {
    const std::uint32_t i = order_[j].second;
    for (std::uint32_t k = 0; k < kBlock; k += 4) {
      const float depth = depths_[i].of[k];
      if (ShareOfExact(depth) > 0.0f) exact_depths_.Add(PointOf(points_[i], k), depth, i, k);
    }
  }
  exact_depths_.End();
}

// All places of a piece have one normal, so that their moment is that of their middle.
void SmallContact::AddPiece(std::uint32_t i, float voxel_m, float weight, ContactPatch* patch) {
  const PointBlock& block = points_[i];
  F4 depth{};
  F4 square{};
  F4 at[3] = {};
  F4 deepest = F4{} - 1e9f;
  for (std::uint32_t k = 0; k < kBlock; k += 4) {
    const float change = exact_[i].of[k] - depths_[i].of[k];
    const F4 corrected = LoadF4(depths_[i].of + k) + change;
    StoreF4(exact_[i].of + k, corrected);
    deepest = Greater(deepest, corrected);
    const F4 inside = Positive(corrected);
    depth += inside;
    square += inside * inside;
    at[0] += inside * LoadF4(block.x + k);
    at[1] += inside * LoadF4(block.y + k);
    at[2] += inside * LoadF4(block.z + k);
  }
  const float scale = weight * block.area_m2[0] * voxel_m;
  const float volume_m3 = scale * SumOfLanes(depth);
  patch->volume_m3 += volume_m3;
  patch->square_m4 += scale * voxel_m * SumOfLanes(square);
  patch->force_m3 += volume_m3 * inwards_[i];
  patch->moment_m4 +=
      scale * glm::cross(glm::vec3(SumOfLanes(at[0]), SumOfLanes(at[1]), SumOfLanes(at[2])), inwards_[i]);
  const float deepest_m = LargestLane(deepest) * voxel_m;
  if (!(deepest_m > 0.0f)) return;
  for (std::uint32_t k = 0; k < kBlock; ++k) sums_.places_inside += exact_[i].of[k] > 0.0f ? 1 : 0;
  if (deepest_m > patch->penetration_m) {
    patch->penetration_m = deepest_m;
    patch->p_S = PointOf(block, FindDeepest(exact_[i].of));
  }
  if (deepest_m > deepest_of_pieces_m_) {
    deepest_of_pieces_m_ = deepest_m;
    deepest_piece_ = i;
  }
  for (std::uint32_t k = 0; k < kBlock; k += 4) OfferAsDeepest(i, k, voxel_m);
}

void SmallContact::OfferAsDeepest(std::uint32_t piece, std::uint32_t place, float voxel_m) {
  const float depth_m = exact_[piece].of[place] * voxel_m;
  if (!(depth_m > 0.0f) || depth_m <= sums_.deepest_m) return;
  sums_.deepest_m = depth_m;
  sums_.deepest_p_S = PointOf(points_[piece], place);
  sums_.deepest_n_S = inwards_[piece];
}

double SmallContact::ComputeExactDepth_m(const DistanceField& field, const core::Pose& X_GS, const glm::vec3& p_S,
                                         double depth_m, float exact_share) {
  if (field.facets.blocks.empty() || !(exact_share > 0.0f)) return depth_m;
  exact_[0].of[0] = static_cast<float>(depth_m / field.voxel_size_m);
  exact_depths_.Begin(field, X_GS, exact_share, exact_.data());
  exact_depths_.Add(p_S, exact_[0].of[0], 0, 0);
  exact_depths_.End();
  return static_cast<double>(exact_[0].of[0]) * field.voxel_size_m;
}

// Takes exact depths at all places of the piece with the deepest one: the largest of many depths with errors is biased
// (0.04 voxel; so 0.002: decision 16).
void SmallContact::FindDeepestPlace(const DistanceField& field, const core::Pose& X_GS, float exact_share) {
  if (!(deepest_of_pieces_m_ > 0.0f)) return;
  const std::uint32_t i = deepest_piece_;
  exact_[i] = depths_[i];
  if (!field.facets.blocks.empty() && exact_share > 0.0f) {
    exact_depths_.Begin(field, X_GS, exact_share, exact_.data());
    for (std::uint32_t k = 0; k < kBlock; ++k) exact_depths_.Add(PointOf(points_[i], k), depths_[i].of[k], i, k);
    exact_depths_.End();
  }
  for (std::uint32_t k = 0; k < kBlock; ++k) OfferAsDeepest(i, k, static_cast<float>(field.voxel_size_m));
}

// Adds the pieces, times weight, to the sums and as patches.
void SmallContact::AddPieces(float voxel_m, float weight) {
  deepest_of_pieces_m_ = 0.0f;
  const std::uint32_t in_patch = (pieces_.count + kMostPatches / 2 - 1) / (kMostPatches / 2);
  for (std::uint32_t begin = 0; begin < pieces_.count; begin += in_patch) {
    ContactPatch patch;
    for (std::uint32_t i = begin; i < std::min(pieces_.count, begin + in_patch); ++i) {
      AddPiece(i, voxel_m, weight, &patch);
    }
    sums_.force_m3 += glm::dvec3(patch.force_m3);
    sums_.moment_m4 += glm::dvec3(patch.moment_m4);
    sums_.volume_m3 += static_cast<double>(patch.volume_m3);
    sums_.square_m4 += static_cast<double>(patch.square_m4);
    if (patch.penetration_m > 0.0f) patches_[num_patches_++] = patch;
  }
  sums_.places_tested += std::uint64_t{pieces_.count} * kBlock;
}

bool SmallContact::Integrate(const SurfacePieces& S, const DistanceField& field, const core::Pose& X_GS,
                             const Request& request) {
  sums_ = {};
  num_patches_ = 0;
  SphereSieve sieve(field, X_GS);
  if (!FindCandidates(S, &sieve)) return false;
  // The size that would have just kFewestPlaces, in steps from the finest.
  const double finest_m = kFinest * request.spacing_m;
  const double wanted_m = std::sqrt(request.near_m2 / (kFewestPlaces * kQuarter));
  const double steps = std::max(0.0, 2.0 * std::log2(wanted_m / finest_m));
  const double step = std::floor(steps);
  const auto to_next = static_cast<float>(std::clamp((steps - step - (1.0 - kBlend)) / kBlend, 0.0, 1.0));
  for (int i = 0; i < 2; ++i) {
    const float weight = i == 0 ? 1.0f - to_next : to_next;
    if (!(weight > 0.0f)) continue;
    bool is_divided = false;
    for (double longest_m = finest_m * std::exp2(0.5 * (step + i));
         !is_divided && longest_m < kCoarsest * request.spacing_m; longest_m *= kCoarser) {
      TakeFound(S);
      is_divided = Divide(static_cast<float>(longest_m), field, X_GS);
    }
    if (!is_divided) return false;
    FindDepthsOfPieces(field, X_GS, request.exact_share);
    AddPieces(static_cast<float>(field.voxel_size_m), weight);
    FindDeepestPlace(field, X_GS, request.exact_share);
  }
  return true;
}

}  // namespace vps
