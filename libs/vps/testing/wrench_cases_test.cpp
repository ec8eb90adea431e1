#include "vps/testing/wrench_cases.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "vps/mesh/check_mesh.hpp"
#include "vps/mesh/mass_properties.hpp"
#include "vps/oracle/body_distance.hpp"
#include "vps/testing/part_shapes.hpp"
#include "vps/testing/reference_wrench.hpp"

namespace vps {
namespace {

std::vector<WrenchCase> Generated(CaseSet set, int poses_each) {
  std::vector<WrenchCase> all;
  for (const std::string& family : WrenchFamilies()) {
    if (family == "public") continue;
    auto cases = MakeWrenchCases(family, set, poses_each, {});
    EXPECT_TRUE(cases) << family;
    for (WrenchCase& c : *cases) all.push_back(std::move(c));
  }
  return all;
}

// 0: not a solid with its outside outwards.
double Volume_m3(const TriangleMesh& mesh) {
  const auto properties = ComputeMassProperties(mesh, 1.0);
  return properties ? properties->volume_m3 : 0.0;
}

TEST(WrenchCases, AreOfClosedPartsThatDoNotMeetThemselves) {
  for (const CaseSet set : kCaseSets) {
    for (const WrenchCase& c : Generated(set, 0)) {
      for (const TriangleMesh* mesh : {&c.A, &c.B}) {
        EXPECT_TRUE(IsSimpleSolid(*mesh)) << c.family << " " << c.name;
        EXPECT_GT(Volume_m3(*mesh), 0.0) << c.family << " " << c.name;
      }
    }
  }
}

TEST(WrenchCases, AreTheSameAtEveryCallAndDifferBetweenTheSets) {
  for (const std::string family : {"sharp", "remeshed"}) {
    const auto first = MakeWrenchCases(family, CaseSet::kHeldOut, 1, {});
    const auto again = MakeWrenchCases(family, CaseSet::kHeldOut, 1, {});
    const auto other = MakeWrenchCases(family, CaseSet::kTraining, 1, {});
    ASSERT_TRUE(first && again && other);
    for (std::size_t i = 0; i < first->size(); ++i) {
      EXPECT_EQ((*first)[i].A.vertices, (*again)[i].A.vertices);
      EXPECT_EQ((*first)[i].B.vertices, (*again)[i].B.vertices);
      ASSERT_EQ((*first)[i].poses.size(), (*again)[i].poses.size());
      for (std::size_t k = 0; k < (*first)[i].poses.size(); ++k) {
        EXPECT_EQ((*first)[i].poses[k].X_AB.translation, (*again)[i].poses[k].X_AB.translation);
      }
      EXPECT_NE((*first)[i].B.vertices, (*other)[i].B.vertices);
    }
  }
}

TEST(WrenchCases, MeshTheSamePartInThreeWaysAtTheSamePoses) {
  const auto cases = MakeWrenchCases("remeshed", CaseSet::kTraining, 1, {});
  ASSERT_TRUE(cases);
  ASSERT_EQ(cases->size(), 6U);
  const double area = SurfaceArea_m2((*cases)[0].B);
  const double volume = Volume_m3((*cases)[0].B);
  for (std::size_t i = 1; i < 3; ++i) {
    EXPECT_GT((*cases)[i].B.triangles.size(), 50 * (*cases)[0].B.triangles.size());
    EXPECT_EQ((*cases)[i].poses.back().X_AB.translation, (*cases)[0].poses.back().X_AB.translation);
    EXPECT_NEAR(SurfaceArea_m2((*cases)[i].B), area, 1e-9 * area);
    EXPECT_NEAR(Volume_m3((*cases)[i].B), volume, 1e-9 * volume);
  }
}

TEST(WrenchCases, AnUnknownFamilyIsNamed) {
  const auto cases = MakeWrenchCases("spoons", CaseSet::kTraining, 1, {});
  ASSERT_FALSE(cases);
  EXPECT_NE(cases.error().detail.find("spoons"), std::string::npos);
}

// A flat pose that is not tilted lies face on face: as deep everywhere as in one place.
TEST(ContactPoses, LayFacesOnFacesAndEdgesOnFaces) {
  const TriangleMesh block = MakeBevelledBlock({0.04, 0.05, 0.06}, 1e-3);
  CaseRandom random(1);
  const oracle::MeshDistance exact(block);
  int flat = 0;
  for (const ContactPose& pose : MakeContactPoses(block, block, 2, &random)) {
    const oracle::ContactWrench w = ReferenceWrench(exact, exact, pose.X_AB);
    ASSERT_TRUE(w.has_converged) << ToText(pose.kind);
    const double depth_m = oracle::FindDeepest(exact, exact, pose.X_AB).depth_m;
    if (pose.kind != PoseKind::kSliding) {
      EXPECT_GT(depth_m, 0.0) << ToText(pose.kind);
    }
    if (pose.kind == PoseKind::kEdge) {
      EXPECT_LT(depth_m, 3.0 * 1e-3 * 0.06);
    }
    if (pose.kind == PoseKind::kFlat && flat++ % 2 == 0) {
      EXPECT_LT(depth_m, 1.01e-3 * 0.06);
    }
  }
  EXPECT_EQ(flat, 2);
}

TEST(CompareWrench, CountsDirectionAndCancellation) {
  oracle::ContactWrench reference;
  reference.force_A_m3 = {0.0, 0.0, 2.0};
  reference.depth_integral_m3 = 2.0;
  const WrenchError turned = CompareWrench({0.02, 0.0, 2.0}, {0.0, 0.3, 0.0}, reference, 0.5);
  EXPECT_NEAR(turned.force, 0.01, 1e-12);
  EXPECT_NEAR(turned.moment, 0.3, 1e-12);
  EXPECT_NEAR(turned.direction_rad, 0.01, 1e-6);
  reference.depth_integral_m3 = 100.0;  // opposite sides cancel
  const WrenchError cancelled = CompareWrench({1.0, 0.0, 2.0}, {0.0, 0.5, 0.0}, reference, 0.5);
  EXPECT_NEAR(cancelled.force, 0.01, 1e-12);
  EXPECT_NEAR(cancelled.moment, 0.01, 1e-12);
  EXPECT_TRUE(std::isnan(CompareWrench({0.1, 0.0, 2.0}, {}, reference, 0.5).direction_rad));
}

}  // namespace
}  // namespace vps
