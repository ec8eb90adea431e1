#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "vps/asset/feature_size.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// What a choice of resolution needs of a part.
struct PartSize {
  FeatureSize features;
  Box box;
  double area_m2 = 0.0;
};
PartSize MeasurePart(const TriangleMesh& solid);
// The thinner of its thinnest wall and its narrowest gap; infinite where it has neither.
double SmallestFeature_m(const PartSize& part);

// Whether A's surface is integrated in B's field: A has the smaller feature (thinnest wall or narrowest gap), which a
// field loses where it is narrower than a voxel, and a surface does not. Within 1 % (the measurement's own) they are
// alike, and B is sampled.
bool IsFirstSampled(const PartSize& A, const PartSize& B);

struct ResolutionWish {
  Method method = Method::kFast;
  double accuracy = 0.1;  // of `fast`: wanted error of the force over the integral of depth
  double least_voxel_m = 0.0;
  double largest_voxel_m = std::numeric_limits<double>::infinity();
};

struct ChosenVoxel {
  double size_m = 0.0;
  std::string reason;  // what decided, e.g. "half of its thinnest wall, 2 mm"
};

// The voxel size s of G's field against S: the least of
//  * what shows G's thinnest wall and narrowest gap (LimitsOf): of `fast` half of it, as one voxel shows it and two
//    give it an inside between; of `paper` 1 / (2 sqrt 3) of it, with which it has an inside already;
//  * where a wall of one fits into a gap of the other with clearance c = (gap - wall) / 2 on each side, half of what
//    keeps the clearance free (LimitsOf; the factor of two is not derived): 5 c of `fast`, 0.29 c of `paper`;
//  * there, of `fast`, 25 accuracy c: the field's mean error is at most 0.01 s
//    (docs/performance/vps/field_accuracy.csv), which is the wanted share of a mean depth of c / 4. How deep such a
//    part is pressed is not derived;
//  * 1/256 of G's longest side (not derived).
// No finer than 2,000,000 voxels on G's surface, or of `paper` 50,000,000 in its box: some 150 MB and ten seconds of
// one core (not derived); `reason` says when that ends it.
//
// It knows one wall and one gap of each part. A peg with a thin flange, whose flange is its thinnest wall, does not fit
// into its hole tightly by this measure: there the user names the voxel size.
ChosenVoxel ChooseVoxel(const PartSize& G, const PartSize& S, const ResolutionWish& wish);

// Points on S: one voxel apart, within 1,000 to 100,000 (limits of time and memory, not derived). `fast` takes coarser
// samples as the accuracy allows.
std::uint32_t ChoosePoints(double area_m2, double voxel_size_m);

}  // namespace vps
