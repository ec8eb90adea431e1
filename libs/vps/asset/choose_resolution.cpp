#include "vps/asset/choose_resolution.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace vps {
namespace {

constexpr double kMeanFieldError_voxels = 0.01;
constexpr double kPressedIntoClearance = 0.25;
constexpr double kMostSurfaceVoxels = 2e6;
constexpr double kMostVoxels = 5e7;

std::string Text(const char* format, double length_m) {
  char text[120];
  std::snprintf(text, sizeof text, format, 1e3 * length_m);
  return text;
}

// Between a wall of one and a gap of the other, on each side; infinite where neither fits.
double Clearance_m(const PartSize& G, const PartSize& S) {
  double clearance_m = std::numeric_limits<double>::infinity();
  for (const double room_m : {G.features.gap_m - S.features.thickness_m, S.features.gap_m - G.features.thickness_m}) {
    if (room_m > 0.0) clearance_m = std::min(clearance_m, 0.5 * room_m);  // not a number: no gap and no wall
  }
  return clearance_m;
}

double FinestVoxel_m(const PartSize& G, Method method) {
  if (method == Method::kFast) return std::sqrt(G.area_m2 / kMostSurfaceVoxels);
  const glm::dvec3 size = G.box.upper - G.box.lower;
  return std::cbrt(size.x * size.y * size.z / kMostVoxels);
}

}  // namespace

PartSize MeasurePart(const TriangleMesh& solid) {
  return {MeasureFeatures(solid), BoundingBox(solid), SurfaceArea_m2(solid)};
}

double SmallestFeature_m(const PartSize& part) {
  return std::min(part.features.thickness_m, part.features.gap_m);
}

bool IsFirstSampled(const PartSize& A, const PartSize& B) {
  return SmallestFeature_m(A) < 0.99 * SmallestFeature_m(B);
}

ChosenVoxel ChooseVoxel(const PartSize& G, const PartSize& S, const ResolutionWish& wish) {
  const glm::dvec3 sides = G.box.upper - G.box.lower;
  const double longest_m = std::max({sides.x, sides.y, sides.z});
  ChosenVoxel chosen{longest_m / 256.0, Text("1/256 of its longest side, %.3g mm", longest_m)};
  const auto at_most = [&](double size_m, const char* reason, double length_m) {
    if (size_m < chosen.size_m) chosen = {size_m, Text(reason, length_m)};
  };
  const bool is_fast = wish.method == Method::kFast;
  const FeatureLimits voxel = LimitsOf(wish.method, 1.0);
  const FeatureSize& has = G.features;
  const double across = std::max(2.0, voxel.thickness_m);
  at_most(has.thickness_m / across,
          is_fast ? "half of its thinnest wall, %.3g mm" : "its thinnest wall, %.3g mm, shows", has.thickness_m);
  at_most(has.gap_m / across, is_fast ? "half of its narrowest gap, %.3g mm" : "its narrowest gap, %.3g mm, shows",
          has.gap_m);
  const double clearance_m = Clearance_m(G, S);
  at_most(0.5 * clearance_m / voxel.clearance_m, "a clearance of %.3g mm to the other part stays free", clearance_m);
  if (is_fast) {
    at_most(kPressedIntoClearance / kMeanFieldError_voxels * wish.accuracy * clearance_m,
            "the accuracy in a clearance of %.3g mm to the other part", clearance_m);
  }
  const auto at_least = [&](double size_m, const char* what) {
    if (size_m <= chosen.size_m) return;
    chosen = {size_m, std::string(what) + Text("; %.3g mm would be wanted: ", chosen.size_m) + chosen.reason};
  };
  at_least(FinestVoxel_m(G, wish.method), is_fast ? "the most memory, 2,000,000 voxels on its surface"
                                                  : "the most memory, 50,000,000 voxels in its box");
  at_least(wish.least_voxel_m, "the least that is allowed");
  if (chosen.size_m > wish.largest_voxel_m) chosen = {wish.largest_voxel_m, "the largest that is allowed"};
  return chosen;
}

std::uint32_t ChoosePoints(double area_m2, double voxel_size_m) {
  return static_cast<std::uint32_t>(std::clamp(area_m2 / (voxel_size_m * voxel_size_m), 1e3, 1e5));
}

}  // namespace vps
