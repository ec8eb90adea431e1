#include "tactile/touch.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <numeric>

namespace tactile {
namespace {

constexpr double kStiffness_N_per_m = 2000.0;

// The field body's surface is at z = 0 of G; S is `depth_m` below it.
core::ContactSet PlaneAt(double depth_m, const glm::vec3& n_G = {0.0f, 0.0f, 1.0f}) {
  core::ContactSet set;
  core::ContactPlane plane;
  plane.p_S = static_cast<float>(-depth_m) * n_G;
  plane.n_G = n_G;
  plane.stiffness_N_per_m = kStiffness_N_per_m;
  set.planes.push_back(plane);
  return set;
}

TEST(TouchSum, IsTheDepthAndTheForceOfAPlaneAndPointsToWhatPresses) {
  TouchSum on_sampled, on_field;
  on_sampled.Add(PlaneAt(0.002), {}, {}, true);
  on_field.Add(PlaneAt(0.002), {}, {}, false);
  for (const Touch& touch : {on_sampled.touch(), on_field.touch()}) {
    EXPECT_NEAR(touch.depth_m, 0.002, 1e-9);
    EXPECT_NEAR(touch.force_N, 4.0, 1e-6);
  }
  // n leads from G to S: G is below S, and S above G.
  EXPECT_NEAR(glm::distance(on_sampled.touch().towards_W, {0.0, 0.0, -1.0}), 0.0, 1e-9);
  EXPECT_NEAR(glm::distance(on_field.touch().towards_W, {0.0, 0.0, 1.0}), 0.0, 1e-9);
}

TEST(TouchSum, FollowsTheBodiesOfTheMoment) {
  core::Pose X_WG;
  X_WG.rotation = core::QuaternionFromRollPitchYaw({0.0, glm::half_pi<double>(), 0.0});  // z of G is x of W
  core::Pose X_WS = X_WG;
  X_WS.translation = {0.003, 0.0, 0.0};  // S has left since the set was made
  TouchSum sum;
  sum.Add(PlaneAt(0.002), X_WS, X_WG, true);
  EXPECT_EQ(sum.touch().depth_m, 0.0);
  X_WS.translation = {-0.001, 0.0, 0.0};
  sum.Add(PlaneAt(0.002), X_WS, X_WG, true);
  EXPECT_NEAR(sum.touch().depth_m, 0.003, 1e-9);
  EXPECT_NEAR(glm::distance(sum.touch().towards_W, {-1.0, 0.0, 0.0}), 0.0, 1e-6);
}

TEST(TouchSum, FromAllSidesHasNoDirection) {
  TouchSum sum;
  sum.Add(PlaneAt(0.002), {}, {}, true);
  sum.Add(PlaneAt(0.002, {0.0f, 0.0f, -1.0f}), {}, {}, true);
  EXPECT_EQ(sum.touch().towards_W, glm::dvec3(0.0));
  EXPECT_NEAR(sum.touch().force_N, 8.0, 1e-6);
}

// The angle that a person feels between two motors, from their strengths alone: a linear scale between neighbours
// [VR-OOS, Fig. 14].
double FeltAngle(const std::array<float, 6>& levels) {
  const auto first = static_cast<std::size_t>(std::max_element(levels.begin(), levels.end()) - levels.begin());
  const std::size_t before = (first + 5) % 6, after = (first + 1) % 6;
  const double way = (static_cast<double>(levels[after]) - static_cast<double>(levels[before])) /
                     static_cast<double>(levels[first] + levels[after] + levels[before]);
  return (static_cast<double>(first) + way) * glm::radians(60.0);
}

TEST(ShareRound, TwoMotorsShowTheDirectionAndTheSumIsTheStrength) {
  for (int degree = 0; degree < 360; ++degree) {
    const double angle = glm::radians(static_cast<double>(degree));
    std::array<float, 6> levels{};
    ShareRound({std::cos(angle), std::sin(angle), 0.0}, 0.7, levels);
    const double sum = std::accumulate(levels.begin(), levels.end(), 0.0);
    EXPECT_NEAR(sum, 0.7, 0.007) << degree;
    const auto running = std::count_if(levels.begin(), levels.end(), [](float level) { return level > 1e-6f; });
    EXPECT_LE(running, 2) << degree;
    const double error_deg = glm::degrees(std::remainder(FeltAngle(levels) - angle, glm::two_pi<double>()));
    EXPECT_LT(std::abs(error_deg), 5.0) << degree;
  }
}

TEST(ShareRound, AlongTheLimbAllMotorsShare) {
  std::array<float, 6> levels{};
  ShareRound({0.0, 0.0, 1.0}, 0.6, levels);
  for (const float level : levels) EXPECT_NEAR(level, 0.1, 1e-6);
  ShareRound({0.0, 0.0, 0.0}, 0.6, levels);  // from all sides
  for (const float level : levels) EXPECT_NEAR(level, 0.1, 1e-6);
}

}  // namespace
}  // namespace tactile
