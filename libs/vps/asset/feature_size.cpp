#include "vps/asset/feature_size.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "vps/field/closest_triangle.hpp"

namespace vps {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

struct Probe {
  glm::dvec3 p_m{0.0};
  glm::dvec3 normal{0.0};
};

// Evenly spread by area (stratified along the running sum), and middles of triangles.
std::vector<Probe> Spread(const TriangleMesh& mesh, std::size_t num_probes) {
  std::vector<double> sum(mesh.triangles.size());
  double area = 0.0;
  for (std::size_t t = 0; t < sum.size(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    sum[t] = area += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  std::vector<Probe> probes;
  const auto add = [&](std::size_t t, double u, double v) {
    const auto [a, b, c] = mesh.corners(t);
    const glm::dvec3 n = glm::cross(b - a, c - a);
    if (!(glm::length(n) > 0.0)) return;
    // Off the edges, where the largest ball shrinks to nothing. By 0.1 of the triangle: not derived.
    constexpr double kInset = 0.1;
    u = kInset / 3.0 + (1.0 - kInset) * u;
    v = kInset / 3.0 + (1.0 - kInset) * v;
    probes.push_back({a + u * (b - a) + v * (c - a), glm::normalize(n)});
  };
  for (std::size_t i = 0; i < num_probes; ++i) {
    const double at = area * (static_cast<double>(i) + 0.5) / static_cast<double>(num_probes);
    const auto t = static_cast<std::size_t>(std::lower_bound(sum.begin(), sum.end(), at) - sum.begin());
    double u = std::fmod(0.5 + 0.7548776662466927 * static_cast<double>(i), 1.0);  // R2 sequence
    double v = std::fmod(0.5 + 0.5698402909980532 * static_cast<double>(i), 1.0);
    if (u + v > 1.0) {
      u = 1.0 - u;
      v = 1.0 - v;
    }
    add(std::min(t, sum.size() - 1), u, v);
  }
  const std::size_t step = 1 + mesh.triangles.size() / num_probes;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += step) add(t, 1.0 / 3.0, 1.0 / 3.0);
  return probes;
}

// The same in an order in which neighbours lie far apart: steps of about n over the golden ratio.
std::vector<Probe> Scattered(const std::vector<Probe>& probes) {
  const std::size_t n = probes.size();
  auto step = static_cast<std::size_t>(0.6180339887498949 * static_cast<double>(n)) + 1;
  while (std::gcd(step, n) != 1) ++step;
  std::vector<Probe> scattered(n);
  for (std::size_t i = 0; i < n; ++i) scattered[i] = probes[i * step % n];
  return scattered;
}

// Distance from the probe to the opposite wall, by the largest ball that touches the surface at the probe on the side
// of `direction` and holds no surface; kNone when that ball sits in an edge or a corner, or the wall is no nearer than
// `below_m`.
double LargestBall(const TriangleField& field, const Probe& probe, const glm::dvec3& direction, double below_m,
                   std::size_t* num_tests) {
  // A ball is settled when no surface reaches into it by more than this share of its radius. Not derived: less takes
  // longer in round holes, where many triangles are about as far.
  constexpr double kSettled = 1.0 - 1e-4;
  double radius = 0.5 * below_m;  // a wall is at least a diameter away
  bool is_settled = false;
  bool has_shrunk = false;
  for (int i = 0; i < 40 && !is_settled; ++i) {
    const auto closest = field.ClosestWithin(probe.p_m + radius * direction, radius * kSettled, num_tests);
    if (!closest) break;
    // The ball through both points with its centre on the normal: |p - q|^2 / (2 direction . (q - p)).
    const glm::dvec3 r = closest->point - probe.p_m;
    const double along = glm::dot(direction, r);
    if (!(along > 0.0)) return kNone;
    const double smaller = glm::dot(r, r) / (2.0 * along);
    is_settled = smaller >= radius * kSettled;
    has_shrunk = true;
    radius = std::min(radius, smaller);
    if (i == 39) return kNone;
  }
  if (!has_shrunk) return kNone;
  // A touching point u (unit, from the centre) with direction . u = cos b is sqrt(5/4 - cos b) radii away from the
  // place half a radius ahead of the centre: at most 3/4 of a radius only if cos b >= 11/16, b <= 47 degrees. The
  // nearest surface to that place straight ahead is the wall.
  const auto ahead = field.ClosestWithin(probe.p_m + 1.5 * radius * direction, 0.75 * radius, num_tests);
  return ahead ? 1.5 * radius + std::sqrt(ahead->squared_distance) : kNone;
}

}  // namespace

FeatureSize MeasureFeatures(const TriangleMesh& mesh, std::size_t num_probes) {
  FeatureSize size;
  size.thickness_m = size.gap_m = kNone;
  if (mesh.triangles.empty()) return size;
  const TriangleField field(mesh);
  const Box box = BoundingBox(mesh);
  const double largest_m = 2.0 * glm::length(box.upper - box.lower);
  // Where many triangles are about as far as the wall (a fine sphere), each place costs a look at all of them. After so
  // many looks (some tenths of a second) only what is a tenth smaller than the least so far is looked for. Not derived.
  constexpr std::size_t kMostTests = 5'000'000;
  std::size_t num_tests = 0;
  for (const Probe& probe : Scattered(Spread(mesh, num_probes))) {
    const double part = num_tests < kMostTests ? 1.0 : 0.9;
    const double thickness_m =
        LargestBall(field, probe, -probe.normal, std::min(part * size.thickness_m, largest_m), &num_tests);
    if (thickness_m < size.thickness_m) {
      size.thickness_m = thickness_m;
      size.thinnest_m = probe.p_m - 0.5 * thickness_m * probe.normal;
      size.thinnest_normal = probe.normal;
    }
    const double gap_m = LargestBall(field, probe, probe.normal, std::min(part * size.gap_m, largest_m), &num_tests);
    if (gap_m < size.gap_m) {
      size.gap_m = gap_m;
      size.narrowest_m = probe.p_m + 0.5 * gap_m * probe.normal;
      size.narrowest_normal = probe.normal;
    }
  }
  return size;
}

FeatureLimits LimitsOf(Method method, double voxel_size_m) {
  // fast: walls and gaps at seven tilts, FeatureLimitsTest.HoldForTheFieldOfFast; the clearance is the largest error
  // near a surface (DistanceField.NearTheSurface*).
  if (method == Method::kFast) return {1.0 * voxel_size_m, 1.0 * voxel_size_m, 0.1 * voxel_size_m};
  // paper: a place in the middle of a wall or gap shows when its voxel is no surface voxel. Along the normal a voxel
  // reaches up to its diagonal, sqrt(3), from the place: that much is needed on both sides. A point in a surface voxel
  // is up to a diagonal away from the surface.
  const double diagonal_m = std::sqrt(3.0) * voxel_size_m;
  return {2.0 * diagonal_m, 2.0 * diagonal_m, diagonal_m};
}

}  // namespace vps
