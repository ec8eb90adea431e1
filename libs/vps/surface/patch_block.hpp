#pragma once

#include <cstdint>

#include "vps/walk/walk_kernel.hpp"

namespace vps {

// Sixteen patches of S in rows, for registers of any width. Lengths in metres, vectors in S unless a row says so.
constexpr int kPatchLanes = 16;
constexpr int kFamilySize = 4;  // parts of one patch lie side by side
typedef float PatchRow[kPatchLanes];

// Rows of a patch's geometry: SurfaceNode's, in this order.
enum NodeRow {
  kCentreRow = 0,
  kRadiusRow = 3,
  kAreaRow = 4,
  kAreaVectorRow = 5,
  kNormalMomentRow = 8,  // column by column
  kSpreadRow = 17,       // xx, yy, zz, xy, xz, yz
  kIsFlatRow = 23,       // 1: a triangle or a part of one
  kThicknessRow = 24,
  kCurvatureRow = 25,  // as the spread
  kNodeRows = 31
};

// Rows of the model that a parent has of its parts' depths:  d + g . e - 1/2 e^T H e,  e from its centre.
enum ModelRow { kModelCentre = 0, kModelDepth = 3, kModelSlope = 4, kModelBend = 7, kModelRows = 13 };

// What was read of patches: enough to judge them once more.
struct alignas(64) PatchesRead {
  PatchRow node[kNodeRows];
  PatchRow corners[6];       // of a flat one: two of its corners from the centre; the three add up to 0
  PatchRow depth, slope[3];  // set by `read`; may be replaced before `judge`
  // By how much the parent's prediction is above (over) and below (under) what was read: positive and negative part of
  // the mean over the family, and roots of the family's mean square of what is above and of what is below. Set by
  // `judge` where has_parent; over -1: unknown.
  PatchRow over, under, over_spread, under_spread;
  PatchRow exact;  // 1: the depth is that of G's triangles, 0: of the field
  bool is_asked;   // G's triangles were, for all lanes; where they are too many or too far, the field's depth stays
};

struct alignas(64) PatchBlock : PatchesRead {
  PatchRow parent[kModelRows];  // where has_parent
  bool has_parent;

  // Set by `judge`.
  PatchRow bend[6];                              // H, 1/m
  PatchRow force[3], moment[3], volume, square;  // the patch's integrals; moment about S's origin
  PatchRow bias, deviation;                      // of |force|'s error: of one sign; standard deviation of the rest
  PatchRow support;                              // greatest depth by the model
  std::uint32_t open;                            // lanes whose share is too large
  std::uint32_t read_exactly;                    // of those, lanes whose depth is to be read by triangles instead
  std::uint32_t touches;                         // lanes that are inside at least in part
  std::uint32_t counts;                          // lanes that were kept and have a share
};

// Sums over blocks, lane by lane. kLasting: errors that no opening makes smaller, m^3.
struct alignas(64) PatchSums {
  enum Sum { kFx, kFy, kFz, kMx, kMy, kMz, kVolume, kSquare, kBias, kVariance, kLasting, kNumSums };
  double of[kNumSums][kPatchLanes];
};

// FieldBends' second derivatives at the length h: a sixteen-bit number times kBendStep / h; |H| <= 2 / h, since
// distances are 1-Lipschitz. Its bound: twice that step.
constexpr float kBendStep = 2.0f / 32767.0f;
// Voxels, of the finest level, which FindBend counts from: below it the field is nearly one plane, and over a flat
// patch the depth is greatest at a corner.
constexpr float kLeastBendLength = 2.0f;
static_assert(kLeastBendLength >= 2.0f);  // the finest level has cells of two voxels
constexpr int kMostBendLevels = 8;

// The factors of the estimate, each on a term that README.md derives; chosen on the training workloads of
// `oos bench vps`, and judged by others (docs/performance/vps.md).
constexpr float kMissed = 0.5f;       // of what a parent mispredicted, in the mean and r.m.s.
constexpr float kUnseenBend = 0.1f;   // of FieldBends' bound, where a parent's prediction was tested
constexpr float kUnsure = 0.2f;       // of the correction for the mean bend
constexpr float kStraddling = 0.05f;  // of a node that the surface cuts: error over area times reach
// SurfaceErrorAt is the larger of the r.m.s. error and six times the mean (ComputeBrickTraits).
constexpr float kMeanOfFieldError = 1.0f / 6.0f;
// Half a step of a word's distance, voxels: where a brick's error was rounded to less.
constexpr float kLeastFieldError = 1.0f / 512.0f;
// Error of an exact depth, voxels: a corner's rounding, half a kFacetStep along three axes, and that of a place in
// floats at 256 voxels, 2^-17 twice.
constexpr float kRounding = 3e-5f;
// Of a word's gradient: half a step of 1 / kGradientSteps along three axes.
constexpr float kSlopeError = 0.0137f;
// Farther inside than this the error at the surface is small against the depth, and triangles are far, voxels.
constexpr float kDeepestExact = 2.5f;
// Of FieldBends::inner_errors: over a cell the errors are 0 in the mean (decision 13), over a surface in it they are
// not; along a ridge they are of one sign.
constexpr float kMeanOfInnerError = 0.25f;

struct PatchInput {
  WalkInput field;
  float rotation[3][3];  // R_GS
  const std::uint32_t* bend_numbers;
  const std::uint32_t* bend_cells;
  std::uint32_t bend_begin[kMostBendLevels];  // of each level in bend_numbers
  std::int32_t num_bend_levels;
  const std::uint32_t* brick_errors;  // floats, voxels
  const std::uint32_t* inner_errors;  // the same
  float threshold_m3;                 // a patch with a larger share is opened
  float most_field_error_m;           // in the mean over a patch: with a larger one it is read by triangles
  float per_deviation;                // 1 / standard deviation of the whole force that is expected
  float least_radius_m;               // smaller ones are not opened
  float offset_m;                     // added to all depths
};

}  // namespace vps
