#include "tools/contact/methods/pose_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace contact {
namespace {

using testing::HasSubstr;

TEST(PoseTable, ReadsRowsHeadingAndComments) {
  const auto poses = ParsePoseTable("px,py,pz,qw,qx,qy,qz\r\n# two\n\n 0.1, -2e-3 ,3,1,0,0,0\r\n0,0,0,0,0,0,1", "t");
  ASSERT_TRUE(poses) << poses.error().detail;
  ASSERT_EQ(poses->size(), 2U);
  EXPECT_EQ((*poses)[0].translation, glm::dvec3(0.1, -2e-3, 3));
  EXPECT_EQ((*poses)[1].rotation.z, 1.0);
}

TEST(PoseTable, NormalisesARoundedQuaternion) {
  const auto poses = ParsePoseTable("0,0,0,0.7071,0.7071,0,0\n", "t");
  ASSERT_TRUE(poses);
  EXPECT_NEAR(glm::length((*poses)[0].rotation), 1.0, 1e-15);
}

TEST(PoseTable, ErrorsNameFileAndLine) {
  const auto detail = [](std::string_view text) { return ParsePoseTable(text, "p.csv").error().detail; };
  EXPECT_THAT(detail("0,0,0,1,0,0,0\n0,0,0,1,0,0\n"), HasSubstr("p.csv:2: "));
  EXPECT_THAT(detail("0,0,0,1,0,0,0\n\n0,0,x,1,0,0,0\n"), HasSubstr("p.csv:3: field 3"));
  EXPECT_THAT(detail("0,0,nan,1,0,0,0\n"), HasSubstr("p.csv:1: field 3"));
  EXPECT_THAT(detail("0,0,0,1,1,0,0\n"), HasSubstr("p.csv:1: the quaternion"));
  EXPECT_THAT(detail("0,0,0,0,0,0,0\n"), HasSubstr("length 0, not 1"));
  EXPECT_THAT(detail("# nothing\n"), HasSubstr("p.csv: holds no pose"));
}

}  // namespace
}  // namespace contact
