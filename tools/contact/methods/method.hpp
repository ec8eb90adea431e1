#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/pose.hpp"
#include "core/result.hpp"
#include "vps/asset/cooked_object.hpp"
#include "vps/mesh/triangle_mesh.hpp"
#include "vps/multibody/collision_world.hpp"

namespace contact {

// Result of one pose. Frame: A's mesh frame; moments about B's mesh origin.
struct Answer {
  double signed_distance_m = 0.0;  // negative: deepest penetration
  glm::dvec3 force_A{0.0};         // on B. Depth integral: m^3; sums of [VR-OOS, Eq. 1-2]: m
  glm::dvec3 moment_A{0.0};        // m^4; m^2
  std::uint64_t contacts = 0;
  std::uint64_t points_tested = 0;
  std::optional<double> force_error;  // estimate of |force_A - the exact one|, m^3; none: the method makes none
  bool is_accurate = false;           // the estimate is at most what was asked for
};

// One method of contact query, built for one pair of meshes.
class Method {
 public:
  virtual ~Method() = default;
  virtual Answer Query(const core::Pose& X_AB) = 0;
  // The next query starts anew, if the method remembers the last ones.
  virtual void Forget() {}
};

// A method's resolution. ChooseSetup chooses it from the meshes.
struct Resolution {
  double voxel_size_m = 0.0;     // of the field's body
  std::uint32_t num_points = 0;  // on the sampled body's surface
};

using Cooked = std::shared_ptr<const vps::CookedObject>;

// How vps::Cook reports on A's field and on B's points, and who shares its work; may all be empty.
struct Cooking {
  vps::Progress progress_A{};
  vps::Progress progress_B{};
  core::ParallelFor* workers = nullptr;
};

// Method `paper`: points of B against the voxelmap of A [VR-OOS, Eq. 1-2]: force = lambda sum V n [m], moment =
// lambda sum P x V n [m^2]. With `as_integral` the weight is the area of B / number of points [m^2] instead of lambda,
// which gives m^3 and m^4. Errors: those of vps::Cook.
std::unique_ptr<Method> MakePaperMethod(Cooked A, Cooked B, double area_B_m2, bool as_integral);
core::Result<std::unique_ptr<Method>> MakePaperMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B,
                                                      const Resolution& resolution, const Cooking& cooking = {});

constexpr double kAccuracy = 0.02;

// Method `fast`: vps::QueryFastPair, the depth integral and its moment to `accuracy`, a share of the integral of depth,
// with an estimate of the error. When apart, the first overload returns the query's own distance, that of the nearest
// sample; the second, from meshes, a lower bound of the distance of the surfaces (ApartBound). Errors: those of
// vps::Cook.
struct FastGoal {
  double accuracy = kAccuracy;
  // vps::PairDescription. Here accuracy comes before time: the places take some milliseconds.
  double negligible_N = 0.0;
  std::uint32_t most_places = 200'000;
};
// As a pair of a scenario: what no hand feels does not count, and time is limited.
inline FastGoal AsInScenarios(double accuracy = vps::PairDescription{}.accuracy) {
  return {accuracy, vps::PairDescription{}.negligible_N, vps::PairDescription{}.most_places};
}
// The same time; at 2 %, which scenarios do not ask for by themselves, every error counts.
inline FastGoal InContests(double accuracy) {
  FastGoal goal = AsInScenarios(accuracy);
  if (accuracy == kAccuracy) goal.negligible_N = 0.0;
  return goal;
}
std::unique_ptr<Method> MakeFastMethod(Cooked A, Cooked B, const FastGoal& goal = {});
core::Result<std::unique_ptr<Method>> MakeFastMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B,
                                                     const Resolution& resolution, const FastGoal& goal = {},
                                                     const Cooking& cooking = {});

// The exact answers of vps/oracle: SignedBodyDistance, and IntegrateContactWrench to a relative accuracy.
core::Result<std::unique_ptr<Method>> MakeOracleMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B,
                                                       double relative_accuracy = 1e-4);

}  // namespace contact
