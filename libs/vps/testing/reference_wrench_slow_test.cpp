#include <gtest/gtest.h>

#include "vps/testing/reference_wrench.hpp"
#include "vps/testing/wrench_cases.hpp"

namespace vps {
namespace {

// What the reference states of itself, beside a method's 2 %. Long edges take minutes at the finer accuracy.
TEST(ReferenceWrench, MovesByLessThanATenthOfAPercentWhenRefined) {
  for (const std::string family : {"bevelled", "needles", "sheets"}) {
    const auto cases = MakeWrenchCases(family, CaseSet::kTraining, 1, {});
    ASSERT_TRUE(cases);
    for (const WrenchCase& c : *cases) {
      const oracle::MeshDistance A(c.A);
      const oracle::MeshDistance B(c.B);
      for (const ContactPose& pose : c.poses) {
        if (pose.kind == PoseKind::kEdge) continue;
        const oracle::ContactWrench w = ReferenceWrench(A, B, pose.X_AB);
        EXPECT_TRUE(w.has_converged);
        const oracle::ContactWrench finer = oracle::IntegrateContactWrench(A, B, pose.X_AB, {5e-5, 1'000'000, 1e-22});
        const WrenchError moved = CompareWrench(w.force_A_m3, w.moment_A_m4, finer, RadiusAboutOrigin_m(c.B));
        EXPECT_LT(moved.force, 1e-3) << family << " " << c.name << " " << ToText(pose.kind);
        EXPECT_LT(moved.moment, 1e-3) << family << " " << c.name << " " << ToText(pose.kind);
      }
    }
  }
}

}  // namespace
}  // namespace vps
