// F2, F3, F4: does the force of a contact step where the motion is smooth?
#include <algorithm>
#include <cmath>
#include <random>

#include "tools/failures/field_pair.hpp"
#include "tools/failures/for_all.hpp"
#include "tools/failures/loop.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kSlide_m = 1e-4;  // a cycle: 0.1 m/s
constexpr double kDepth_m = 5e-4;

vps::TriangleMesh Turned(vps::TriangleMesh mesh, const glm::dquat& q) {
  for (glm::dvec3& v : mesh.vertices) v = q * v;
  return mesh;
}

// Range of the force over its mean, and the largest angle to the exact normal.
struct Ripple {
  double range = 0.0;
  double angle_rad = 0.0;
};

class RippleMeter {
 public:
  void Add(const glm::dvec3& force, const glm::dvec3& normal) {
    const double length = glm::length(force);
    least_ = std::min(least_, length);
    most_ = std::max(most_, length);
    sum_ += length;
    ++count_;
    if (length > 0.0)
      ripple_.angle_rad =
          std::max(ripple_.angle_rad, std::acos(std::clamp(glm::dot(force, normal) / length, -1.0, 1.0)));
  }
  [[nodiscard]] Ripple ripple() const {
    return {count_ > 0 && sum_ > 0.0 ? (most_ - least_) * count_ / sum_ : 1e9, ripple_.angle_rad};
  }

 private:
  double least_ = 1e30, most_ = 0.0, sum_ = 0.0;
  int count_ = 0;
  Ripple ripple_;
};

Ripple Worse(const Ripple& a, const Ripple& b) {
  return {std::max(a.range, b.range), std::max(a.angle_rad, b.angle_rad)};
}

constexpr std::uint32_t kPoints = 16384;

Ripple SlideOnPlanes(const Variant& variant) {
  std::mt19937_64 engine(2);
  const auto uniform = [&engine] { return 2.0 * static_cast<double>(engine() >> 11) * 0x1.0p-53 - 1.0; };
  Ripple worst;
  for (int tilt = 0; tilt < 20; ++tilt) {
    const glm::dquat q = core::QuaternionFromRotationVector({uniform(), uniform(), uniform()});
    FieldPair pair(variant, Turned(vps::MakeBox({0.08, 0.08, 0.02}), q), kVoxel_m, vps::MakeSphere(0.02, 96), kPoints);
    RippleMeter meter;
    for (int i = 0; i < 200; ++i) {
      const glm::dvec3 p(kSlide_m * (i - 100), 0.3 * kSlide_m * i, 0.01 + 0.02 - kDepth_m);
      meter.Add(pair.Query({{1, 0, 0, 0}, q * p}).F_So_W.force_N, q * glm::dvec3(0, 0, 1));
    }
    worst = Worse(worst, meter.ripple());
  }
  return worst;
}

// About a sphere and a torus of 25 voxels' radius of curvature; the ball turns with its place, so that it touches with
// the same samples.
Ripple SlideOnCurves(const Variant& variant) {
  constexpr double kR_m = 0.025;
  Ripple worst;
  for (const bool is_torus : {false, true}) {
    FieldPair pair(variant, is_torus ? vps::MakeTorus(0.05, kR_m, 256, 256) : vps::MakeSphere(kR_m, 256), kVoxel_m,
                   vps::MakeSphere(0.01, 96), kPoints);
    RippleMeter meter;
    for (int i = 0; i < 400; ++i) {
      const double angle = 0.2 + kSlide_m / kR_m * i;
      const glm::dvec3 n(std::cos(angle), 0.0, std::sin(angle));
      const glm::dvec3 middle(is_torus ? 0.05 : 0.0, 0.0, 0.0);
      const core::Pose X_GS{core::QuaternionFromRotationVector({0, -angle, 0}), middle + (kR_m + 0.01 - kDepth_m) * n};
      meter.Add(pair.Query(X_GS).F_So_W.force_N, n);
    }
    worst = Worse(worst, meter.ripple());
  }
  return worst;
}

// What the hand feels of it: the device at a constant depth in a plate.
Ripple SlideOfHand(const Variant& variant) {
  SceneKit kit(variant);
  const glm::dquat q = core::QuaternionFromRotationVector({0.3, 0.5, 0.2});
  const auto plate = kit.AddFixed(Turned(vps::MakeBox({0.1, 0.1, 0.02}), q), {}, kVoxel_m);
  const auto ball = kit.AddHand(vps::MakeSphere(0.02, 96), {{1, 0, 0, 0}, q * glm::dvec3(-0.02, 0, 0.032)}, kPoints);
  kit.AddPair(ball, plate).friction = 0.0;
  Loop loop(kit.scenario);
  RippleMeter meter;
  for (int i = 0; i < 900; ++i) {
    const double down = std::min(1.0, i / 300.0);
    const double along = std::max(0, i - 500);
    loop.Tick({{1, 0, 0, 0}, q * glm::dvec3(-0.02 + kSlide_m * along, 0.3 * kSlide_m * along, 0.032 - 0.005 * down)});
    if (i >= 520) meter.Add(loop.command().force_N, q * glm::dvec3(0, 0, 1));
  }
  return meter.ripple();
}

Reading ToReading(const Variant& variant, const Ripple& ripple, double bound) {
  const double degrees = ripple.angle_rad * 180.0 / M_PI;
  return {variant.name, Short(100.0 * ripple.range) + " %; " + Short(degrees) + " deg",
          ripple.range <= bound && degrees <= 0.5};
}

// A flat box of 10 mm, tilted by 0.1 degrees, comes down by 1 um a cycle: the largest step of its force over that of
// the exact integral of depth, both scaled to the same final force.
double LargestStep(const Variant& variant) {
  constexpr double kSide_m = 0.01;
  constexpr double kTilt_rad = 0.1 * M_PI / 180.0;
  constexpr int kSteps = 200;
  FieldPair pair(variant, vps::MakeBox({0.05, 0.05, 0.02}), kVoxel_m, vps::MakeBox(glm::dvec3(kSide_m)), 4096);
  const double rise_m = kSide_m * std::tan(kTilt_rad);
  const auto exact = [rise_m](double h) {  // of the lowest edge at depth h
    if (h <= 0.0) return 0.0;
    return h < rise_m ? 0.5 * h * h / rise_m : h - 0.5 * rise_m;
  };
  std::vector<double> forces;
  for (int i = 0; i <= kSteps; ++i) {
    const double lowest = 0.5 * kSide_m * (std::cos(kTilt_rad) + std::sin(kTilt_rad));
    const core::Pose X_GS{core::QuaternionFromRotationVector({0, kTilt_rad, 0}),
                          {1e-4, 2e-4, 0.01 + lowest - 1e-6 * i}};
    forces.push_back(pair.Query(X_GS).F_So_W.force_N.z);
  }
  const double scale = forces.back() / exact(1e-6 * kSteps);
  if (!(scale > 0.0)) return 1e9;
  double worst = 0.0;
  for (int i = 10; i <= kSteps; ++i) {
    const double expected = scale * (exact(1e-6 * i) - exact(1e-6 * (i - 1)));
    worst = std::max(
        worst, std::abs(forces[static_cast<std::size_t>(i)] - forces[static_cast<std::size_t>(i - 1)]) / expected);
  }
  return worst;
}

// Range of the force over its mean, of a ball at one depth in a plate with more and more points, at random attitudes.
double SpreadOverPoints(const Variant& variant) {
  std::mt19937_64 engine(4);
  const auto uniform = [&engine] { return 3.0 * static_cast<double>(engine() >> 11) * 0x1.0p-53 - 1.5; };
  double least = 1e30;
  double most = 0.0;
  double sum = 0.0;
  int count = 0;
  for (const std::uint32_t points : {1000U, 4000U, 16000U, 64000U}) {
    FieldPair pair(variant, vps::MakeBox({0.1, 0.1, 0.02}), kVoxel_m, vps::MakeSphere(0.02, 96), points);
    for (int i = 0; i < 20; ++i) {
      const glm::dquat q = core::QuaternionFromRotationVector({uniform(), uniform(), uniform()});
      const double force =
          glm::length(pair.Query({q, {0.001 * uniform(), 0.001 * uniform(), 0.01 + 0.02 - kDepth_m}}).F_So_W.force_N);
      least = std::min(least, force);
      most = std::max(most, force);
      sum += force;
      ++count;
    }
  }
  return (most - least) * count / sum;
}

}  // namespace

void StudySteps(Report* report) {
  Row plane{"F2",
            "force steps of voxels",
            "ball slides 0.5 mm deep at 0.1 m/s over a plane, 20 tilts, voxels of 1 mm",
            "range of the pair's force, of its mean; direction off",
            "<= 0.5 %; <= 0.5 deg",
            {},
            "a depth is that of a layer of voxels"};
  Row curve = plane;
  curve.set_up = "ball slides 0.5 mm deep at 0.1 m/s round a sphere and a torus of 25 voxels' radius";
  curve.bound = "<= 2 %; <= 0.5 deg";
  Row hand = plane;
  hand.set_up = "device slides 3 mm deep in a tilted plate at 0.1 m/s";
  hand.observable = "range of the hand's force, of its mean; direction off";
  hand.why = "the proxy lags behind a moving device";
  Row step{"F3",
           "force jump as the number of contacts changes",
           "flat box of 10 mm, tilted by 0.1 deg, comes down by 1 um a cycle",
           "largest step of the force over the exact one",
           "<= 2",
           {},
           "each further point changes the scale of all (Eq. 2)"};
  Row spread{"F4",
             "stiffness depends on sampling",
             "ball at one depth in a plate, 1k to 64k points, 20 attitudes each",
             "range of the force, of its mean",
             "<= 5 %",
             {},
             "`paper`: the force grows with the number of points (Eq. 2); `fast`: a scenario asks for a tenth of the "
             "integral of depth, and few samples give it"};
  const auto on_planes = OfVariants(SlideOnPlanes);
  const auto on_curves = OfVariants(SlideOnCurves);
  const auto of_hand = OfVariants(SlideOfHand);
  const auto largest = OfVariants(LargestStep);
  const auto ranges = OfVariants(SpreadOverPoints);
  for (std::size_t i = 0; i < Variants().size(); ++i) {
    const Variant& variant = Variants()[i];
    plane.readings.push_back(ToReading(variant, on_planes[i], 0.005));
    curve.readings.push_back(ToReading(variant, on_curves[i], 0.02));
    hand.readings.push_back(ToReading(variant, of_hand[i], 0.005));
    step.readings.push_back({variant.name, Short(largest[i]), largest[i] <= 2.0});
    spread.readings.push_back({variant.name, Short(100.0 * ranges[i]) + " %", ranges[i] <= 0.05});
  }
  for (const Row& row : {plane, curve, hand, step, spread}) AddRow(report, row);
}

}  // namespace failures
