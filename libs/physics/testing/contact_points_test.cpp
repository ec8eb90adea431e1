#include "physics/testing/contact_points.hpp"

#include <cmath>
#include <functional>
#include <vector>

#include "physics/testing/bodies.hpp"
#include "physics/testing/trials/reference.hpp"

namespace physics {
namespace {

using Planes = core::FixedVector<core::ContactPlane, core::kMaxContactPlanes>;

struct Sum {
  glm::dvec3 force_N{0.0};
  glm::dvec3 torque_Nm{0.0};  // about S's origin
  double moment_Nm = 0.0;     // sum of magnitudes: the scale of a torque whose parts cancel
  void Add(const glm::dvec3& lever, const glm::dvec3& force) {
    force_N += force;
    torque_Nm += glm::cross(lever, force);
    moment_Nm += glm::length(glm::cross(lever, force));
  }
};

Sum Of(const std::vector<ContactPoint>& points, const core::Pose& X_WS) {
  Sum sum;
  for (const ContactPoint& p : points) {
    sum.Add(p.p_W - X_WS.translation, p.stiffness_N_per_m * std::max(0.0, -p.gap_m) * p.n_W);
  }
  return sum;
}

Sum Of(const Planes& planes, const core::Pose& X_WS, const core::Pose& X_WG) {
  Sum sum;
  for (const core::ContactPlane& plane : planes) {
    const glm::dvec3 n_W = X_WG.rotate(glm::dvec3(plane.n_G));
    const glm::dvec3 p_W = X_WS * glm::dvec3(plane.p_S);
    const double gap = glm::dot(n_W, p_W - X_WG * glm::dvec3(plane.q_G));
    sum.Add(p_W - X_WS.translation, plane.stiffness_N_per_m * std::max(0.0, -gap) * n_W);
  }
  return sum;
}

// 100 x 100 points on a square of 0.1 m, `shape` is z over x and y; gaps against the plane z = 0.
std::vector<ContactPoint> Grid(const std::function<double(double, double)>& shape) {
  std::vector<ContactPoint> points;
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 100; ++j) {
      const double x = (i - 49.5) * 1e-3;
      const double y = (j - 49.5) * 1e-3;
      points.push_back({{x, y, 0.0}, {0, 0, 1}, shape(x, y), 5.0});
    }
  }
  return points;
}

void ExpectSameWrench(const char* name, const std::vector<ContactPoint>& points) {
  const core::Pose X_WS{core::QuaternionFromRotationVector({0.3, -0.2, 0.9}), {0.02, -0.03, 0.2}};
  const core::Pose X_WG{core::QuaternionFromRotationVector({-0.1, 0.4, 0.2}), {-0.05, 0.01, -0.1}};
  Planes planes;
  ReduceContactPoints(points, X_WS, X_WG, &planes);
  EXPECT_LE(planes.size(), 20u) << name;
  const Sum all = Of(points, X_WS);
  const Sum few = Of(planes, X_WS, X_WG);
  EXPECT_LT(glm::length(few.force_N - all.force_N), 0.01 * glm::length(all.force_N)) << name;
  EXPECT_LT(glm::length(few.torque_Nm - all.torque_Nm), 0.01 * glm::length(all.torque_Nm)) << name;
  testing::Test::RecordProperty(
      name, std::to_string(planes.size()) + " planes, force " +
                std::to_string(glm::length(few.force_N - all.force_N) / glm::length(all.force_N)) + ", torque " +
                std::to_string(glm::length(few.torque_Nm - all.torque_Nm) / glm::length(all.torque_Nm)));
}

TEST(ContactPoints, FewPlanesActLikeTenThousandPoints) {
  ExpectSameWrench("flat", Grid([](double, double) { return -1e-4; }));
  ExpectSameWrench("tilted", Grid([](double x, double y) { return -1e-4 + 0.001 * x - 0.0005 * y; }));
  ExpectSameWrench("one_edge", Grid([](double x, double) { return 0.0045 - 0.1 * x; }));
  ExpectSameWrench("one_corner", Grid([](double x, double y) { return 0.0085 - 0.1 * (x + y); }));
  ExpectSameWrench("ring", Grid([](double x, double y) { return std::abs(std::hypot(x, y) - 0.04) - 5e-4; }));
  ExpectSameWrench("wavy", Grid([](double x, double y) { return 1e-4 * std::sin(200 * x) * std::cos(150 * y); }));
  ExpectSameWrench("two_feet", Grid([](double x, double) { return 4e-4 - 0.01 * std::abs(x - 0.01); }));
}

TEST(ContactPoints, FewPlanesActLikeCurvedContact) {
  std::vector<ContactPoint> ball;  // pressed 1 mm into a socket that is 20 mm wider
  std::vector<ContactPoint> peg;   // in a hole, pressed aside and tilted
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 100; ++j) {
      const double a = 0.012 * i;
      const double b = 2 * 3.14159265358979 * j / 100.0;
      const glm::dvec3 n(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), -std::cos(a));
      ball.push_back({0.03 * n + glm::dvec3(0.01, 0, 0), -n, -1e-3 + 0.02 * (1 - std::cos(a)), std::sin(a)});
      const glm::dvec3 r(std::cos(b), std::sin(b), 0.0);
      const double z = 1e-3 * i;
      peg.push_back({0.02 * r + glm::dvec3(0, 0, z), -r, 1e-4 - 4e-4 * r.x * (z - 0.02) / 0.05, 1.0});
    }
  }
  ExpectSameWrench("ball", ball);
  ExpectSameWrench("peg", peg);
}

TEST(ContactPoints, PlanesResistTiltingLikeThePoints) {
  const auto flat = [](double tilt) { return Grid([tilt](double x, double) { return -1e-3 + tilt * x; }); };
  Planes planes;
  ReduceContactPoints(flat(0.0), {}, {}, &planes);
  const core::Pose tilted{core::QuaternionFromRotationVector({0, -1e-3, 0}), {}};  // z = +1e-3 x
  const double few = Of(planes, tilted, {}).torque_Nm.y;
  const double all = Of(flat(1e-3), {}).torque_Nm.y;
  EXPECT_NEAR(few / all, 1.0, 1e-3);
}

TEST(ContactPoints, ApproachingPointsAreIncluded) {
  Planes planes;
  ReduceContactPoints(Grid([](double x, double) { return 1e-3 + 0.01 * x; }), {}, {}, &planes);
  ASSERT_FALSE(planes.empty());
  double smallest = 1e9;
  for (const core::ContactPlane& plane : planes) {
    smallest = std::min(smallest, static_cast<double>(plane.p_S.z) - static_cast<double>(plane.q_G.z));
  }
  EXPECT_NEAR(smallest, 1e-3 - 0.01 * 0.0495, 1e-6);
  ReduceContactPoints({}, {}, {}, &planes);
  EXPECT_TRUE(planes.empty());
}

TEST(ContactPoints, FlatPressOfTenThousandPointsDoesNotRock) {
  EXPECT_LT(trials::RockingOfAPress_m(0.5), 5e-6);
}

}  // namespace
}  // namespace physics
