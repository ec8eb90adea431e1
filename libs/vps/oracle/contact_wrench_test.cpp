#include "vps/oracle/contact_wrench.hpp"

#include <gtest/gtest.h>

#include "vps/oracle/closed_form.hpp"
#include "vps/testing/shapes.hpp"

namespace vps::oracle {
namespace {

core::Pose Pose(const glm::dvec3& p, const glm::dvec3& rotation_vector = glm::dvec3(0.0)) {
  return {core::QuaternionFromRotationVector(rotation_vector), p};
}

// The block's upper face is z = 0 of its frame moved by half its height.
const MeshDistance& Ground() {
  static const MeshDistance ground(MakeBox({0.4, 0.4, 0.2}));
  return ground;
}

TEST(ContactWrench, OfAPlateOnAHalfSpaceIsAreaTimesDepth) {
  const MeshDistance plate(MakeBox({0.06, 0.04, 0.02}));
  const double depth = 0.003;
  const glm::dvec3 p(0.01, -0.02, 0.1 + 0.01 - depth);
  const ContactWrench w = IntegrateContactWrench(Ground(), plate, Pose(p));
  ASSERT_TRUE(w.has_converged);
  const double force = PlateOnHalfSpaceForce(0.06 * 0.04, depth);
  EXPECT_NEAR(w.force_A_m3.z, force, 1e-4 * force);
  EXPECT_NEAR(glm::length(glm::dvec2(w.force_A_m3)), 0.0, 1e-4 * force);
  EXPECT_NEAR(glm::length(w.moment_A_m4), 0.0, 1e-4 * force * 0.04);
}

TEST(ContactWrench, MomentIsAboutTheOriginOfB) {
  TriangleMesh mesh = MakeBox({0.06, 0.04, 0.02});
  const glm::dvec3 offset(0.05, -0.03, 0.02);  // from B's origin to the plate's centre
  for (glm::dvec3& v : mesh.vertices) v += offset;
  const MeshDistance plate(mesh);
  const double depth = 0.002;
  const core::Pose X_AB = Pose(glm::dvec3(0.0, 0.0, 0.1 + 0.01 - depth) - offset);
  const ContactWrench w = IntegrateContactWrench(Ground(), plate, X_AB);
  const double force = PlateOnHalfSpaceForce(0.06 * 0.04, depth);
  const glm::dvec3 expected = glm::cross(offset, glm::dvec3(0.0, 0.0, force));
  EXPECT_NEAR(glm::distance(w.moment_A_m4, expected), 0.0, 2e-4 * glm::length(expected));
}

// The tolerance is that of the sphere's facets: a sphere of 192 segments is short by (pi / 192)^2 / 2 = 1.3e-4 R.
TEST(ContactWrench, OfASphereOnAHalfSpaceIsTheCapsVolume) {
  const double R = 0.03;
  const MeshDistance sphere(MakeSphere(R, 192));
  for (const double depth : {0.003, 0.01}) {
    const ContactWrench w = IntegrateContactWrench(Ground(), sphere, Pose({0.0, 0.0, 0.1 + R - depth}));
    ASSERT_TRUE(w.has_converged);
    const double force = SphereOnHalfSpaceForce(R, depth);
    EXPECT_NEAR(w.force_A_m3.z, force, (1e-4 + 3e-4 * R / depth) * force) << depth;
    EXPECT_LT(glm::length(glm::dvec2(w.force_A_m3)), 1e-3 * force);
  }
}

// The peg ends inside the hole, so no rim shortens the depth; both polygons have their corners at the same angles.
TEST(ContactWrench, OfAPressedPegFollowsTheClosedForm) {
  const double peg = 0.01, hole = 0.0101, shift = 0.0003;
  const MeshDistance block(MakeBlockWithHole(0.06, 0.006, hole, 96));
  const MeshDistance pin(MakeCylinder(peg, 0.004, 96));
  const ContactWrench w = IntegrateContactWrench(block, pin, Pose({shift, 0.0, 0.0}), {1e-3});
  const double force = PegInHoleForce(shift, peg, hole, 0.004);
  EXPECT_NEAR(w.force_A_m3.x, -force, 0.01 * force);
  EXPECT_LT(std::hypot(w.force_A_m3.y, w.force_A_m3.z), 0.01 * force);
}

TEST(ContactWrench, TurnsWithTheFrame) {
  const MeshDistance A(MakeBox({0.4, 0.4, 0.2}));
  const MeshDistance B(MakeBox({0.05, 0.05, 0.05}));
  const core::Pose X_AB = Pose({0.02, 0.01, 0.12}, {0.3, -0.2, 0.5});
  const ContactWrench w = IntegrateContactWrench(A, B, X_AB);
  ASSERT_GT(w.depth_integral_m3, 0.0);
  // The same pair with A's mesh turned: the wrench turns with it.
  const core::Pose X_CA = Pose({0.3, -0.1, 0.2}, {-0.4, 0.9, 0.1});
  TriangleMesh turned = MakeBox({0.4, 0.4, 0.2});
  for (glm::dvec3& v : turned.vertices) v = X_CA * v;
  const ContactWrench c = IntegrateContactWrench(MeshDistance(turned), B, X_CA * X_AB);
  EXPECT_LT(glm::distance(c.force_A_m3, X_CA.rotate(w.force_A_m3)), 2e-4 * glm::length(w.force_A_m3));
  EXPECT_LT(glm::distance(c.moment_A_m4, X_CA.rotate(w.moment_A_m4)), 2e-4 * 0.04 * glm::length(w.force_A_m3));
}

TEST(ContactWrench, TighterAccuracyMovesItByLessThanTheBound) {
  const MeshDistance A(MakeTorus(0.1, 0.04, 64, 32));
  const MeshDistance B(MakeTorus(0.05, 0.02, 64, 32));
  const core::Pose X_AB = Pose({0.205, 0.0, 0.0}, {0.4, 0.2, 0.1});
  const ContactWrench coarse = IntegrateContactWrench(A, B, X_AB, {1e-2});
  const ContactWrench fine = IntegrateContactWrench(A, B, X_AB, {1e-4});
  ASSERT_TRUE(fine.has_converged);
  ASSERT_GT(glm::length(fine.force_A_m3), 0.0);
  EXPECT_LT(glm::distance(coarse.force_A_m3, fine.force_A_m3), coarse.error_bound_m3 + fine.error_bound_m3);
}

TEST(ContactWrench, IsZeroWhenApartAndOnASheet) {
  const MeshDistance box(MakeBox({0.05, 0.05, 0.05}));
  EXPECT_EQ(IntegrateContactWrench(Ground(), box, Pose({0.0, 0.0, 0.126})).depth_integral_m3, 0.0);
  TriangleMesh sheet;
  sheet.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const MeshDistance two_sided(sheet, MeshDistance::Sides::kSheet);
  EXPECT_EQ(IntegrateContactWrench(two_sided, box, Pose({0.0, 0.0, 0.01})).depth_integral_m3, 0.0);
}

}  // namespace
}  // namespace vps::oracle
