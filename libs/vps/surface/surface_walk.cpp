#include "vps/surface/surface_walk.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "vps/field/nearest_facet.hpp"

namespace vps {
namespace {

// Blocks whose depths are read by triangles at once. Not derived: bounds memory.
constexpr std::size_t kExactAtOnce = 16;
// An error that does not count whatever was asked for, as a depth over all of S: it ends the search where nothing
// touches. Not derived.
constexpr double kNegligible_m = 1e-15;
// Parts of triangles that are smaller are not opened, voxels: far below the field's own resolution. Not derived.
constexpr float kLeastRadius = 1e-3f;
// Ends passes that come no nearer; places end them before.
constexpr int kMostPasses = 24;
// Of the threshold from pass to pass, at least: a larger step would open far more than is needed. Not derived.
constexpr double kLeastStep = 1.0 / 64.0;
// From query to query: of the threshold where more was done than asked for, at most.
constexpr double kLooser = 4.0;  // one halving of patches takes the error to a quarter
// Thresholds aim at a little less than the error that is wanted. Not derived.
constexpr double kAim = 0.8;
// What is wanted is shared evenly: between random errors and those of one sign, between the field and the patches.
constexpr double kHalf = 0.5;
// In a block.
constexpr std::size_t kFamilies = kPatchLanes / kFamilySize;

// Exact depths of groups within this radius are found together, voxels. Not derived: wider groups are near more facets.
constexpr float kWidestGroup = 3.0f;
constexpr double kReachOfTriangles = 3.0;  // voxels: kDeepestExact and kMostFieldError
// Of time, a search of the triangle that is nearest to one place takes as much as so many places of the field. Measured
// deep inside training parts: 9 (44 triangles) to 64 (16,000).
constexpr std::uint64_t kPlacesOfSearch = 32;

// Depths that the field gives; by triangles where those are found afterwards.
void SetByField(PatchesRead* block) {
  block->is_asked = false;
  std::fill_n(block->exact, kPatchLanes, 0.0f);
}

bool IsCompact(const PatchBlock& block, float radius_m) {
  const auto place = [&](int k) {
    return glm::vec3(block.node[kCentreRow][k], block.node[kCentreRow + 1][k], block.node[kCentreRow + 2][k]);
  };
  for (int k = 1; k < kPatchLanes; ++k) {
    const glm::vec3 from = place(k) - place(0);
    if (glm::dot(from, from) > radius_m * radius_m) return false;
  }
  return true;
}

std::uint64_t CountDeep(const PatchBlock& block, float depth_m) {
  std::uint64_t count = 0;
  for (int k = 0; k < kPatchLanes; ++k) count += block.node[kAreaRow][k] > 0.0f && block.depth[k] > depth_m ? 1 : 0;
  return count;
}

}  // namespace

SurfaceWalk::SurfaceWalk(InstructionSet set)
    : kernels_(KernelsOf(set)),
      parts_(kMostParts),
      exact_(kExactAtOnce),
      exact_origins_(kExactAtOnce),
      facet_points_(kExactAtOnce),
      facets_(std::make_unique<FacetScratch>()) {}

// A level with n patches reads 4 n places, each of which may be opened. A place may be read once by the field and once
// by triangles, and each level may leave one more block that is not full.
void SurfaceWalk::Reserve(std::size_t most_places) {
  const std::size_t most_blocks = 3 * (most_places / kPatchLanes + 1) + kMostPasses;
  kept_.reserve(most_blocks);
  last_kept_.reserve(most_blocks);
  asked_.reserve(2 * (most_places + kPatchLanes));
  for (Level* level : {&now_, &next_}) {
    level->by_field.reserve(most_places + kPatchLanes);
    level->by_triangles.reserve(most_places + kPatchLanes);
  }
}

void SurfaceWalk::SetPose(const core::Pose& X_GS) {
  in_.field = MakeFieldInput(*G_, X_GS);
  for (int j = 0; j < 3; ++j) {
    glm::dvec3 e(0.0);
    e[j] = 1.0;
    const glm::dvec3 column = X_GS.rotate(e);
    for (int i = 0; i < 3; ++i) in_.rotation[i][j] = static_cast<float>(column[i]);
  }
  in_.bend_numbers = bends_->numbers.data();
  in_.bend_cells = bends_->words.data();
  in_.num_bend_levels = static_cast<std::int32_t>(bends_->begin.size());
  for (std::size_t i = 0; i < bends_->begin.size(); ++i) in_.bend_begin[i] = bends_->begin[i];
  in_.brick_errors = reinterpret_cast<const std::uint32_t*>(bends_->brick_errors.data());
  in_.inner_errors = reinterpret_cast<const std::uint32_t*>(bends_->inner_errors.data());
  in_.least_radius_m = kLeastRadius * static_cast<float>(G_->voxel_size_m);
}

// The corners of a flat patch, from its centre.
void SurfaceWalk::SetCorners(const SurfacePiece& triangle, std::size_t lane, PatchBlock* block, Origins* origins) {
  origins->triangles[lane] = triangle;
  for (int k = 0; k < 2; ++k) {
    for (int i = 0; i < 3; ++i) {
      block->corners[3 * k + i][lane] = triangle.corners[k + 1][i] - block->node[kCentreRow + i][lane];
    }
  }
}

void SurfaceWalk::FillRoots(PatchBlock* block, Origins* origins) const {
  const SurfaceFamily& roots = S_->families.front();
  for (int row = 0; row < kNodeRows; ++row) {
    for (int k = 0; k < kPatchLanes; ++k) {
      const bool is_one = k < kFamilySize;
      block->node[row][k] = is_one || row != kAreaRow ? roots.of[row][k % kFamilySize] : 0.0f;
    }
  }
  for (int k = 0; k < kPatchLanes; ++k) {
    block->over[k] = block->under[k] = block->over_spread[k] = block->under_spread[k] = -1.0f;
    origins->below[k] = roots.below[k % kFamilySize];
    if (roots.of[kIsFlatRow][k % kFamilySize] > 0.0f) {
      SetCorners(S_->triangles[roots.below[k % kFamilySize]], static_cast<std::size_t>(k), block, origins);
    }
  }
  block->has_parent = false;
  SetByField(block);
}

// The parts of up to four patches.
void SurfaceWalk::FillParts(const Opened* opened, std::size_t count, PatchBlock* block, Origins* origins) const {
  for (std::size_t f = 0; f < kFamilies; ++f) {
    const Opened& from = opened[std::min(f, count - 1)];
    const std::size_t at = f * kFamilySize;
    for (int row = 0; row < kModelRows; ++row) {
      for (std::size_t k = 0; k < kFamilySize; ++k) block->parent[row][at + k] = from.model[row];
    }
    if (from.is_flat) {
      // Quarters: similar to the whole, so that a quarter of its area has a sixteenth of its spread.
      const auto& [a, b, c] = from.triangle.corners;
      const glm::vec3 ab = 0.5f * (a + b);
      const glm::vec3 bc = 0.5f * (b + c);
      const glm::vec3 ca = 0.5f * (c + a);
      const SurfacePiece parts[kFamilySize] = {{{a, ab, ca}}, {{ab, b, bc}}, {{ca, bc, c}}, {{bc, ca, ab}}};
      for (std::size_t k = 0; k < kFamilySize; ++k) {
        const auto& corners = parts[k].corners;
        const glm::vec3 centre = (corners[0] + corners[1] + corners[2]) * (1.0f / 3.0f);
        for (int i = 0; i < 3; ++i) {
          block->node[kCentreRow + i][at + k] = centre[i];
          block->node[kAreaVectorRow + i][at + k] = 0.25f * from.area_vector[i];
        }
        block->node[kRadiusRow][at + k] = 0.5f * from.radius;
        block->node[kAreaRow][at + k] = 0.25f * from.area;
        for (int i = 0; i < 9; ++i) block->node[kNormalMomentRow + i][at + k] = 0.0f;
        for (int i = 0; i < 6; ++i) block->node[kSpreadRow + i][at + k] = 0.0625f * from.spread[i];
        block->node[kIsFlatRow][at + k] = 1.0f;
        block->node[kThicknessRow][at + k] = 0.0f;
        for (int i = 0; i < 6; ++i) block->node[kCurvatureRow + i][at + k] = 0.0f;
        SetCorners(parts[k], at + k, block, origins);
      }
    } else {
      const SurfaceFamily& family = S_->families[from.below];
      for (int row = 0; row < kNodeRows; ++row) {
        std::memcpy(&block->node[row][at], family.of[row], sizeof family.of[row]);
      }
      for (std::size_t k = 0; k < kFamilySize; ++k) {
        origins->below[at + k] = family.below[k];
        if (family.of[kIsFlatRow][k] > 0.0f) SetCorners(S_->triangles[family.below[k]], at + k, block, origins);
      }
    }
    if (f >= count) {
      for (std::size_t k = 0; k < kFamilySize; ++k) block->node[kAreaRow][at + k] = 0.0f;
    }
  }
  block->has_parent = true;
  SetByField(block);
}

void SurfaceWalk::Put(const PatchBlock& block, const Origins& origins, int lane) {
  auto& list = block.is_asked ? next_.by_triangles : next_.by_field;
  Opened& to = list.emplace_back();
  for (int i = 0; i < 3; ++i) {
    to.model[kModelCentre + i] = block.node[kCentreRow + i][lane];
    to.model[kModelSlope + i] = block.slope[i][lane];
    to.force[i] = block.force[i][lane];
    to.moment[i] = block.moment[i][lane];
  }
  to.model[kModelDepth] = block.depth[lane];
  for (int i = 0; i < 6; ++i) to.model[kModelBend + i] = block.bend[i][lane];
  to.is_flat = block.node[kIsFlatRow][lane] > 0.5f;
  if (to.is_flat) {
    to.triangle = origins.triangles[lane];
    to.radius = block.node[kRadiusRow][lane];
    to.area = block.node[kAreaRow][lane];
    for (int i = 0; i < 3; ++i) to.area_vector[i] = block.node[kAreaVectorRow + i][lane];
    for (int i = 0; i < 6; ++i) to.spread[i] = block.node[kSpreadRow + i][lane];
  } else {
    to.below = origins.below[lane];
  }
  to.volume = block.volume[lane];
  to.square = block.square[lane];
  to.bias = block.bias[lane];
  to.deviation = block.deviation[lane];
}

// As `judge` takes it.
float SurfaceWalk::ShareOf(const Opened& o) const {
  return o.bias + o.deviation * o.deviation * in_.per_deviation;
}

float SurfaceWalk::deepest_exact_m() const {
  return in_.offset_m + kDeepestExact * static_cast<float>(G_->voxel_size_m);
}

// False: no places are left for the search that a place so deep takes.
bool SurfaceWalk::TakeSearch(float depth_m) {
  if (depth_m <= deepest_exact_m()) return true;
  if (result_.places_read + kPlacesOfSearch > most_places_) return false;
  result_.places_read += kPlacesOfSearch;
  return true;
}

// Leaves in now_ the patches with the largest shares, as many as places are left for; the others count as themselves.
// False: not all could stay.
bool SurfaceWalk::FitLevel() {
  asked_.clear();
  std::uint64_t places = 0;
  const auto places_of = [&](const Opened& o, const std::vector<Opened>* list) {
    const bool is_search = list == &now_.by_triangles && o.model[kModelDepth] > deepest_exact_m();
    return kFamilySize * (1 + (is_search ? kPlacesOfSearch : 0));
  };
  for (const auto* list : {&now_.by_field, &now_.by_triangles}) {
    for (const Opened& o : *list) {
      asked_.push_back({ShareOf(o), places_of(o, list)});
      places += asked_.back().places;
    }
  }
  const std::uint64_t left = most_places_ - std::min(most_places_, result_.places_read);
  if (places <= left) return true;
  std::sort(asked_.begin(), asked_.end(), [](const Asked& a, const Asked& b) { return a.share > b.share; });
  float least = std::numeric_limits<float>::infinity();
  std::uint64_t of_least = 0;  // places for patches whose share is `least`: of equal ones the first
  places = 0;
  for (const auto* list : {&now_.by_field, &now_.by_triangles}) {  // whose last blocks may not be full
    if (!list->empty()) places += kPatchLanes - kFamilySize;
  }
  for (const Asked& asked : asked_) {
    places += asked.places;
    if (places > left) break;
    of_least = asked.places + (asked.share < least ? 0 : of_least);
    least = asked.share;
  }
  for (auto* list : {&now_.by_field, &now_.by_triangles}) {
    std::erase_if(*list, [&](const Opened& o) {
      const float share = ShareOf(o);
      if (share > least) return false;
      if (const std::uint64_t of_this = places_of(o, list); share == least && of_this <= of_least) {
        of_least -= of_this;
        return false;
      }
      KeepUnopened(o);
      return true;
    });
  }
  return false;
}

// The same patch, to be judged anew with its exact depth.
void SurfaceWalk::PutAgain(const PatchBlock& block, const Origins& origins, int lane) {
  if (num_again_ == kPatchLanes) ReadAgain();
  const int to = num_again_++;
  for (int row = 0; row < kNodeRows; ++row) again_.node[row][to] = block.node[row][lane];
  for (int i = 0; i < 3; ++i) again_.slope[i][to] = block.slope[i][lane];
  for (int i = 0; i < 6; ++i) again_.corners[i][to] = block.corners[i][lane];
  again_.depth[to] = block.depth[lane];
  again_.over[to] = block.over[lane];
  again_.under[to] = block.under[lane];
  again_.over_spread[to] = block.over_spread[lane];
  again_.under_spread[to] = block.under_spread[lane];
  again_origins_.below[to] = origins.below[lane];
  again_origins_.triangles[to] = origins.triangles[lane];
}

// Moves the patches of again_ to the exact blocks.
void SurfaceWalk::ReadAgain() {
  if (num_again_ == 0) return;
  for (int k = num_again_; k < kPatchLanes; ++k) {  // places of the last, without area
    for (int row = 0; row < kNodeRows; ++row) again_.node[row][k] = again_.node[row][num_again_ - 1];
    for (int i = 0; i < 3; ++i) again_.slope[i][k] = again_.slope[i][num_again_ - 1];
    again_.node[kAreaRow][k] = 0.0f;
    again_.depth[k] = again_.depth[num_again_ - 1];
  }
  again_.has_parent = false;
  SetByField(&again_);
  exact_[num_exact_] = again_;
  exact_origins_[num_exact_] = again_origins_;
  num_again_ = 0;
  if (++num_exact_ == kExactAtOnce) ReadExactDepths();
}

// Those of patches that lie within a few voxels are read together.
void SurfaceWalk::ReadExactDepths() {
  const auto voxel_m = static_cast<float>(G_->voxel_size_m);
  const float per_voxel = 1.0f / voxel_m;
  const std::size_t count = std::exchange(num_exact_, 0);
  for (std::size_t i = 0; i < count; ++i) exact_[i].is_asked = true;
  std::size_t num_groups = 0;
  std::array<std::size_t, kExactAtOnce> groups{};
  for (std::size_t i = 0; i < count; ++i) {
    PatchBlock& block = exact_[i];
    if (!IsCompact(block, kWidestGroup * voxel_m) || CountDeep(block, deepest_exact_m()) > 0) {
      ReadOneByOne(&block);
      continue;
    }
    FacetPoints& points = facet_points_[num_groups];
    std::memcpy(points.x, block.node[kCentreRow], sizeof points.x);
    std::memcpy(points.y, block.node[kCentreRow + 1], sizeof points.y);
    std::memcpy(points.z, block.node[kCentreRow + 2], sizeof points.z);
    for (int k = 0; k < kPatchLanes; ++k) points.depth[k] = (block.depth[k] - in_.offset_m) * per_voxel;
    groups[num_groups++] = i;
  }
  kernels_.measure(in_.field, facet_points_.data(), static_cast<std::uint32_t>(num_groups), facets_.get());
  for (std::size_t n = 0; n < num_groups; ++n) {
    PatchBlock& block = exact_[groups[n]];
    const FacetPoints& points = facet_points_[n];
    for (int k = 0; k < kPatchLanes; ++k) {
      if (points.gx[k] == 0.0f && points.gy[k] == 0.0f && points.gz[k] == 0.0f) continue;
      SetExact(in_.offset_m + points.depth[k] * voxel_m, glm::vec3(points.gx[k], points.gy[k], points.gz[k]), k,
               &block);
    }
  }
  for (std::size_t i = 0; i < count; ++i) Judge(&exact_[i], exact_origins_[i]);
}

void SurfaceWalk::SetExact(float depth_m, const glm::vec3& gradient, int lane, PatchBlock* block) const {
  block->exact[lane] = 1.0f;
  block->depth[lane] = depth_m;
  for (int i = 0; i < 3; ++i) {
    block->slope[i][lane] =
        -(in_.rotation[0][i] * gradient.x + in_.rotation[1][i] * gradient.y + in_.rotation[2][i] * gradient.z);
  }
}

// The gradient of the distance is the direction from the nearest place; on a face, the triangle's normal. Deep inside
// the distance is off by at most sqrt(3) edges of a coarse cell: it and the cell's plane both fall by no more than the
// way from the cell's centre, half a diagonal; and by a quarter of one more, the mean over a cell (decision 13). Where
// no triangle is found within that, the field's depth stays.
void SurfaceWalk::ReadOneByOne(PatchBlock* block) {
  const auto voxel_m = static_cast<float>(G_->voxel_size_m);
  const double coarse = (std::sqrt(3.0) + 0.25) * (1 << G_->coarse_shift);
  for (int k = 0; k < kPatchLanes; ++k) {
    if (!(block->node[kAreaRow][k] > 0.0f)) continue;
    glm::dvec3 p;
    for (int i = 0; i < 3; ++i) {
      p[i] = static_cast<double>(in_.field.t[i]);
      for (int j = 0; j < 3; ++j) {
        p[i] += static_cast<double>(in_.field.m[i][j]) * static_cast<double>(block->node[kCentreRow + j][k]);
      }
    }
    const double depth = static_cast<double>(block->depth[k] - in_.offset_m) / G_->voxel_size_m;
    const bool is_deep = depth > static_cast<double>(kDeepestExact);
    const double reach = is_deep ? depth + coarse : kReachOfTriangles;
    const NearestFacet nearest = FindNearestFacet(G_->triangles(), p, reach);
    if (!nearest.is_found) continue;
    const glm::dvec3 away = p - nearest.place;
    const double distance = glm::length(away);
    constexpr double kAtThePlace = 1e-4;  // voxels; the direction of a shorter way is rounding
    const glm::dvec3 gradient = nearest.is_on_face || distance < kAtThePlace
                                    ? nearest.normal
                                    : away / (nearest.height < 0.0 ? -distance : distance);
    SetExact(in_.offset_m - static_cast<float>(nearest.height) * voxel_m, glm::vec3(gradient), k, block);
  }
}

void SurfaceWalk::Judge(PatchBlock* block, const Origins& origins) {
  kernels_.judge(in_, block, &sums_);
  for (unsigned lanes = block->touches & ~block->open; lanes != 0; lanes &= lanes - 1) {
    ++result_.patches_inside;
    const int lane = __builtin_ctz(lanes);
    if (static_cast<double>(block->support[lane]) > result_.deepest_m) SetDeepest(*block, lane);
  }
  AddParts(*block);
  if (block->counts != 0) Keep(*block, origins);
  for (unsigned lanes = block->open; lanes != 0; lanes &= lanes - 1) {
    const int lane = __builtin_ctz(lanes);
    const bool is_asked_next = !block->is_asked && in_.field.num_facet_levels > 0;
    if (is_asked_next && (block->read_exactly >> lane & 1U) != 0 && TakeSearch(block->depth[lane])) {
      PutAgain(*block, origins, lane);
    } else {
      Put(*block, origins, lane);
    }
  }
}

// For the next pass. Lanes without a share would have none then, either.
void SurfaceWalk::Keep(const PatchBlock& block, const Origins& origins) {
  Kept& kept = kept_.emplace_back(Kept{block, origins});
  for (int k = 0; k < kPatchLanes; ++k) {
    if ((block.counts >> k & 1U) == 0) kept.patches.node[kAreaRow][k] = 0.0f;
  }
}

void SurfaceWalk::JudgeKept() {
  std::swap(kept_, last_kept_);
  kept_.clear();
  PatchBlock block;
  block.has_parent = false;  // its parts were compared with it
  for (const Kept& kept : last_kept_) {
    static_cast<PatchesRead&>(block) = kept.patches;
    Judge(&block, kept.origins);
  }
}

void SurfaceWalk::JudgeRoots() {
  kept_.clear();
  PatchBlock roots;
  Origins origins;
  FillRoots(&roots, &origins);
  kernels_.read(in_, &roots);
  result_.places_read += kPatchLanes;
  Judge(&roots, origins);
}

void SurfaceWalk::ReadByField(const std::vector<Opened>& opened) {
  PatchBlock block;
  Origins origins;
  for (std::size_t i = 0; i < opened.size(); i += kFamilies) {
    FillParts(&opened[i], std::min(kFamilies, opened.size() - i), &block, &origins);
    kernels_.read(in_, &block);
    result_.places_read += kPatchLanes;
    Judge(&block, origins);
  }
}

void SurfaceWalk::ReadByTriangles(const std::vector<Opened>& opened) {
  for (std::size_t i = 0; i < opened.size(); i += kFamilies) {
    PatchBlock& block = exact_[num_exact_];
    FillParts(&opened[i], std::min(kFamilies, opened.size() - i), &block, &exact_origins_[num_exact_]);
    kernels_.read(in_, &block);
    result_.places_read += kPatchLanes + kPlacesOfSearch * CountDeep(block, deepest_exact_m());
    if (++num_exact_ == kExactAtOnce) ReadExactDepths();
  }
}

void SurfaceWalk::KeepUnopened(const Opened& o) {
  const auto add = [&](int sum, float value) { sums_.of[sum][0] += static_cast<double>(value); };
  for (int i = 0; i < 3; ++i) {
    add(PatchSums::kFx + i, o.force[i]);
    add(PatchSums::kMx + i, o.moment[i]);
  }
  add(PatchSums::kVolume, o.volume);
  add(PatchSums::kSquare, o.square);
  add(PatchSums::kBias, o.bias);
  sums_.of[PatchSums::kVariance][0] += static_cast<double>(o.deviation) * static_cast<double>(o.deviation);
  if (!(o.volume > 0.0f)) return;
  ContactPatch& part = *NextPart();
  const glm::vec3 slope(o.model[kModelSlope], o.model[kModelSlope + 1], o.model[kModelSlope + 2]);
  for (int i = 0; i < 3; ++i) {
    part.p_S[i] = o.model[kModelCentre + i];
    part.n_G[i] = -glm::dot(slope, glm::vec3(in_.rotation[i][0], in_.rotation[i][1], in_.rotation[i][2]));
    part.force_m3[i] = o.force[i];
    part.moment_m4[i] = o.moment[i];
  }
  const float depth_m = o.model[kModelDepth];
  part.penetration_m = std::max(depth_m, 0.0f);
  part.volume_m3 = o.volume;
  part.square_m4 = o.square;
  ++result_.patches_inside;
  if (static_cast<double>(depth_m) <= result_.deepest_m) return;
  result_.deepest_m = static_cast<double>(depth_m);
  result_.deepest_p_S = part.p_S;
}

// Goes on from what the last pass kept. Sets result_ but for is_accurate. False: places ran out.
bool SurfaceWalk::Pass(double threshold_m3, double deviation_m3) {
  in_.threshold_m3 = static_cast<float>(threshold_m3);
  in_.per_deviation = static_cast<float>(1.0 / deviation_m3);
  std::memset(&sums_, 0, sizeof sums_);
  result_.deepest_m = 0.0;
  result_.patches_inside = 0;
  now_.by_field.clear();
  now_.by_triangles.clear();
  next_.by_field.clear();
  next_.by_triangles.clear();
  num_again_ = 0;
  num_exact_ = 0;
  num_parts_ = 0;
  bool is_whole = true;
  result_.passes == 0 ? JudgeRoots() : JudgeKept();
  ++result_.passes;
  while (true) {
    ReadAgain();
    if (num_exact_ > 0) ReadExactDepths();
    if (next_.by_field.empty() && next_.by_triangles.empty()) break;
    std::swap(now_, next_);
    next_.by_field.clear();
    next_.by_triangles.clear();
    is_whole = FitLevel() && is_whole;
    ReadByField(now_.by_field);
    ReadByTriangles(now_.by_triangles);
  }
  double of[PatchSums::kNumSums];
  for (int s = 0; s < PatchSums::kNumSums; ++s) {
    of[s] = 0.0;
    for (const double value : sums_.of[s]) of[s] += value;
  }
  result_.force_m3 = {of[PatchSums::kFx], of[PatchSums::kFy], of[PatchSums::kFz]};
  result_.moment_m4 = {of[PatchSums::kMx], of[PatchSums::kMy], of[PatchSums::kMz]};
  result_.volume_m3 = of[PatchSums::kVolume];
  result_.square_m4 = of[PatchSums::kSquare];
  result_.error_m3 = kConfidence * (of[PatchSums::kBias] + std::sqrt(of[PatchSums::kVariance]));
  lasting_m3_ = of[PatchSums::kLasting];
  return is_whole;
}

// The parts of a pair in the order of the walk, so that neighbours in the list are neighbours on S.
ContactPatch* SurfaceWalk::NextPart() {
  if (num_parts_ == kMostParts) {
    for (std::size_t i = 0; i < kMostParts / 2; ++i) {
      const ContactPatch& a = parts_[2 * i];
      const ContactPatch& b = parts_[2 * i + 1];
      ContactPatch sum = a.penetration_m >= b.penetration_m ? a : b;
      sum.force_m3 = a.force_m3 + b.force_m3;
      sum.moment_m4 = a.moment_m4 + b.moment_m4;
      sum.volume_m3 = a.volume_m3 + b.volume_m3;
      sum.square_m4 = a.square_m4 + b.square_m4;
      parts_[i] = sum;
    }
    num_parts_ = kMostParts / 2;
  }
  ContactPatch* const part = &parts_[num_parts_++];
  *part = {};
  return part;
}

void SurfaceWalk::SetDeepest(const PatchBlock& block, int lane) {
  result_.deepest_m = static_cast<double>(block.support[lane]);
  const glm::vec3 centre(block.node[kCentreRow][lane], block.node[kCentreRow + 1][lane],
                         block.node[kCentreRow + 2][lane]);
  const glm::vec3 slope(block.slope[0][lane], block.slope[1][lane], block.slope[2][lane]);
  glm::vec3 from_centre(0.0f);
  if (block.node[kIsFlatRow][lane] > 0.5f) {
    const glm::vec3 b(block.corners[0][lane], block.corners[1][lane], block.corners[2][lane]);
    const glm::vec3 c(block.corners[3][lane], block.corners[4][lane], block.corners[5][lane]);
    from_centre = -(b + c);
    for (const glm::vec3& corner : {b, c}) {
      if (glm::dot(slope, corner) > glm::dot(slope, from_centre)) from_centre = corner;
    }
  }
  result_.deepest_p_S = centre + from_centre;
}

// One for each family.
void SurfaceWalk::AddParts(const PatchBlock& block) {
  const unsigned kept = block.touches & ~block.open;
  for (int f = 0; f < kPatchLanes; f += kFamilySize) {
    unsigned lanes = kept >> f & ((1U << kFamilySize) - 1U);
    if (lanes == 0) continue;
    ContactPatch& part = *NextPart();
    int deepest = -1;
    for (; lanes != 0; lanes &= lanes - 1) {
      const int k = f + __builtin_ctz(lanes);
      for (int i = 0; i < 3; ++i) {
        part.force_m3[i] += block.force[i][k];
        part.moment_m4[i] += block.moment[i][k];
      }
      part.volume_m3 += block.volume[k];
      part.square_m4 += block.square[k];
      if (deepest < 0 || block.support[k] > block.support[deepest]) deepest = k;
    }
    part.penetration_m = block.support[deepest];
    glm::vec3 slope;
    for (int i = 0; i < 3; ++i) {
      part.p_S[i] = block.node[kCentreRow + i][deepest];
      slope[i] = block.slope[i][deepest];
    }
    for (int i = 0; i < 3; ++i)
      part.n_G[i] = -glm::dot(slope, glm::vec3(in_.rotation[i][0], in_.rotation[i][1], in_.rotation[i][2]));
  }
}

const SurfaceWalk::Result& SurfaceWalk::Run(const SurfaceTree& S, const DistanceField& G, const FieldBends& bends,
                                            const core::Pose& X_GS, const SurfaceGoal& goal, SurfaceMemory* memory) {
  S_ = &S;
  G_ = &G;
  bends_ = &bends;
  most_places_ = goal.most_places;
  SetPose(X_GS);
  in_.offset_m = static_cast<float>(goal.offset_m);
  result_ = {};
  const double negligible_m3 = std::max(kNegligible_m * S.area_m2, goal.negligible_m3);
  // First as if all of S were a voxel deep.
  double wanted_m3 = goal.accuracy * S.area_m2 * G.voxel_size_m;
  const double first_threshold_m3 = wanted_m3 / kConfidence;
  double threshold_m3 = first_threshold_m3;
  double carrying_m2 = 0.0;
  std::uint64_t affordable_places = 0;
  const bool is_known = memory != nullptr && memory->threshold_m3 > 0.0;
  if (is_known) {
    wanted_m3 = memory->wanted_m3;
    threshold_m3 = memory->threshold_m3;
    carrying_m2 = memory->carrying_m2;
    affordable_places = memory->affordable_places;
  }
  double whole_threshold_m3 = 0.0;
  std::uint64_t whole_places = 0;
  while (result_.passes < kMostPasses) {
    // The field may take half of what is wanted; all, where no triangles are kept that know better.
    in_.most_field_error_m = in_.field.num_facet_levels > 0
                                 ? static_cast<float>(kHalf * wanted_m3 / kConfidence / std::max(carrying_m2, 1e-30))
                                 : std::numeric_limits<float>::infinity();
    const bool is_whole = Pass(threshold_m3, kHalf * wanted_m3 / kConfidence);
    wanted_m3 = std::max(goal.accuracy * result_.volume_m3, negligible_m3);
    carrying_m2 = result_.volume_m3 * result_.volume_m3 / std::max(result_.square_m4, 1e-300);
    if (!is_whole) {
      // The next query begins with the pass before, if there is one. Of a known contact that pass is its last.
      threshold_m3 = whole_places > 0 ? whole_threshold_m3 : kLooser * threshold_m3;
      affordable_places = is_known ? whole_places : 0;
      break;
    }
    whole_threshold_m3 = threshold_m3;
    whole_places = result_.places_read;
    // What opening can reach; where more than half of what is wanted stays whatever is opened, it is not worth while.
    const double reachable_m3 = std::max(wanted_m3 - lasting_m3_, kHalf * wanted_m3);
    const double factor = reachable_m3 / std::max(result_.error_m3, 1e-300);
    if (factor >= 1.0) {
      // More than was asked for: the next query may do with less, but not with less than a first one.
      const double looser_m3 = threshold_m3 * std::clamp(kAim * factor * factor, 1.0, kLooser);
      threshold_m3 = std::max(threshold_m3, std::min(looser_m3, first_threshold_m3));
      affordable_places = 0;
      break;
    }
    // Halving patches takes their shares to a sixteenth and the whole error to a quarter: thresholds go with its
    // square.
    double step = std::max(kAim * factor * factor, kLeastStep);
    if (is_known) {
      // A contact that needs more than its budget keeps from query to query the threshold that this suffices for: its
      // force would step with what happens to be opened last. Halving patches takes four times as many places: their
      // number goes with one over the root of the threshold. What was too much is tried again where this pass reads
      // half of what it did then.
      const double filled = static_cast<double>(whole_places) / (kAim * static_cast<double>(most_places_));
      const bool was_too_much = affordable_places > 0 && 2 * whole_places > affordable_places;
      if (was_too_much) affordable_places = std::max(affordable_places, whole_places);
      if (was_too_much || filled * filled > kAim) break;
      step = std::max(step, filled * filled);
    }
    threshold_m3 *= step;
  }
  if (memory != nullptr) *memory = {threshold_m3, wanted_m3, carrying_m2, affordable_places};
  // No opening makes that smaller.
  result_.error_m3 += lasting_m3_;
  result_.is_accurate = result_.error_m3 <= wanted_m3;
  return result_;
}

}  // namespace vps
