#include "vps/oracle/body_distance.hpp"

#include <gtest/gtest.h>

#include <random>

#include "vps/oracle/closed_form.hpp"
#include "vps/oracle/exact_distance.hpp"
#include "vps/testing/pose_at.hpp"
#include "vps/testing/shapes.hpp"

namespace vps::oracle {
namespace {

struct Uniform {
  std::mt19937_64 random{11};
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1.0p-53;
  }
};

TEST(MeshDistance, EqualsExhaustiveSearch) {
  for (const TriangleMesh& mesh : {MakeTorus(0.1, 0.04, 40, 20), MakeBlockWithHole(0.3, 0.2, 0.1, 32)}) {
    const MeshDistance fast(mesh);
    const ExactDistance slow(mesh);
    Uniform uniform;
    for (int i = 0; i < 1500; ++i) {
      const glm::dvec3 p(uniform(-0.2, 0.2), uniform(-0.2, 0.2), uniform(-0.2, 0.2));
      EXPECT_NEAR(fast.SignedDistance(p), slow.SignedDistance(p), 1e-14);
      EXPECT_EQ(fast.IsInside(p), slow.WindingNumber(p) > 0.5);
    }
  }
}

// Where corners of the mesh lie on the shape, box and plate are exact; round shapes are off by their facets' sagitta.
TEST(MeshDistance, EqualsTheClosedForms) {
  const MeshDistance box(MakeBox({0.3, 0.2, 0.1}));
  const MeshDistance sphere(MakeSphere(0.1, 256));
  const MeshDistance cylinder(MakeCylinder(0.08, 0.2, 512));
  const MeshDistance torus(MakeTorus(0.1, 0.04, 512, 256));
  const MeshDistance hole(MakeBlockWithHole(0.3, 0.2, 0.1, 512));
  const MeshDistance plate(MakeBox({5.0, 5.0, 0.02}));
  Uniform uniform;
  for (int i = 0; i < 1000; ++i) {
    const glm::dvec3 p(uniform(-0.2, 0.2), uniform(-0.2, 0.2), uniform(-0.2, 0.2));
    EXPECT_NEAR(box.SignedDistance(p), BoxDistance(p, {0.3, 0.2, 0.1}), 1e-14);
    EXPECT_NEAR(plate.SignedDistance(p), PlateDistance(p, 0.02), 1e-14);
    EXPECT_NEAR(sphere.SignedDistance(p), SphereDistance(p, 0.1), 0.1 * 1.6e-4);
    EXPECT_NEAR(cylinder.SignedDistance(p), CylinderDistance(p, 0.08, 0.2), 0.08 * 2e-5);
    EXPECT_NEAR(torus.SignedDistance(p), TorusDistance(p, 0.1, 0.04), 0.14 * 4e-5);
    EXPECT_NEAR(hole.SignedDistance(p), BlockWithHoleDistance(p, 0.3, 0.2, 0.1), 0.1 * 2e-5);
  }
}

TEST(MeshDistance, AnOpenSheetHasTwoSidesAndNoInside) {
  TriangleMesh mesh;
  mesh.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  const MeshDistance sheet(mesh, MeshDistance::Sides::kSheet);
  EXPECT_NEAR(sheet.SignedDistance({0.2, 0.1, 0.05}), 0.05, 1e-15);
  EXPECT_NEAR(sheet.SignedDistance({0.2, 0.1, -0.05}), 0.05, 1e-15);
}

TEST(MeshDistance, IsNegativeInsideASolidWithASmallHole) {
  TriangleMesh mesh = MakeSphere(0.1, 32);
  mesh.triangles.erase(mesh.triangles.begin() + 40);
  const MeshDistance sphere(mesh);
  EXPECT_LT(sphere.SignedDistance({0.0, 0.0, 0.0}), 0.0);
  EXPECT_GT(sphere.SignedDistance({0.11, 0.0, 0.0}), 0.0);
}

TEST(TriangleDistance, CoversCrossingsFacesEdgesAndCorners) {
  const Triangle t{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  EXPECT_EQ(TriangleDistance(t, {{{0.2, 0.2, -1}, {0.2, 0.2, 1}, {0.3, 0.9, 1}}}), 0.0);
  EXPECT_NEAR(TriangleDistance(t, {{{0.2, 0.2, 0.5}, {0.2, 0.2, 1}, {0.3, 0.3, 1}}}), 0.5, 1e-15);
  EXPECT_NEAR(TriangleDistance(t, {{{-1, 0.5, 1}, {-1, 0.5, -1}, {-2, 0.5, 0}}}), 1.0, 1e-15);
  EXPECT_NEAR(TriangleDistance(t, {{{2, 0, 0}, {3, 0, 0}, {3, 1, 0}}}), 1.0, 1e-15);
}

TEST(BodyDistance, OfTwoBoxesApartIsTheGap) {
  const MeshDistance A(MakeBox({0.2, 0.2, 0.2}));
  const MeshDistance B(MakeBox({0.1, 0.1, 0.1}));
  EXPECT_NEAR(SignedBodyDistance(A, B, At(0.17, 0.02, 0.0)).signed_distance_m, 0.02, 1e-14);
  EXPECT_NEAR(SignedBodyDistance(A, B, At(0.16, 0.17, 0.0)).signed_distance_m, std::hypot(0.01, 0.02), 1e-14);
}

TEST(BodyDistance, OfABoxInAFaceIsItsDepth) {
  const MeshDistance A(MakeBox({0.2, 0.2, 0.2}));
  const MeshDistance B(MakeBox({0.1, 0.1, 0.1}));
  const BodyDistance d = SignedBodyDistance(A, B, At(0.02, 0.0, 0.147));
  EXPECT_NEAR(d.signed_distance_m, -0.003, 3e-6);
  EXPECT_LE(d.error_bound_m, 3e-6);
}

TEST(BodyDistance, OfTwoSpheresFollowsTheirCentres) {
  const MeshDistance A(MakeSphere(0.05, 128));
  const MeshDistance B(MakeSphere(0.03, 128));
  for (const double gap : {0.004, -0.002, -0.01}) {
    const double c = 0.08 + gap;
    EXPECT_NEAR(SignedBodyDistance(A, B, At(0.6 * c, 0.0, 0.8 * c, {0.1, 0.2, 0.3})).signed_distance_m, gap, 5e-5);
  }
}

// A thin pin through a thick wall: no point of the pin is deeper than half the wall, none of the wall deeper than the
// pin's radius.
TEST(BodyDistance, CountsPenetrationOfEitherSurface) {
  const MeshDistance wall(MakeBox({0.2, 0.2, 0.02}));
  const MeshDistance pin(MakeCylinder(0.002, 0.1, 64));
  const BodyDistance d = SignedBodyDistance(wall, pin, At(0.0, 0.0, 0.0));
  EXPECT_NEAR(d.signed_distance_m, -0.01, 1e-5);
  EXPECT_TRUE(d.is_deepest_in_A);
  const BodyDistance swapped = SignedBodyDistance(pin, wall, At(0.0, 0.0, 0.0));
  EXPECT_NEAR(swapped.signed_distance_m, -0.01, 1e-5);
  EXPECT_FALSE(swapped.is_deepest_in_A);
}

TEST(BodyDistance, OfABodyInsideTheOtherIsItsDepth) {
  const MeshDistance A(MakeBox({0.2, 0.2, 0.2}));
  const MeshDistance B(MakeSphere(0.02, 64));
  EXPECT_NEAR(SignedBodyDistance(A, B, At(0.0, 0.0, 0.03)).signed_distance_m, -0.09, 9e-5);
}

}  // namespace
}  // namespace vps::oracle
