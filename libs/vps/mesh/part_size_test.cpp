#include "vps/mesh/part_size.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

using testing::HasSubstr;

Box Cube(double side_m) {
  return BoundingBox(MakeBox({side_m, side_m, side_m}));
}

TEST(PartSize, TakesAMillimetreAndTenMetres) {
  EXPECT_TRUE(CheckPartSize("a.obj", Cube(0.001)));
  EXPECT_TRUE(CheckPartSize("a.obj", Cube(10.0)));
}

TEST(PartSize, NamesFileSizeAndFixOfAWrongUnit) {
  const std::string large = CheckPartSize("a.obj", Cube(180.0)).error().detail;
  EXPECT_THAT(large, HasSubstr("a.obj"));
  EXPECT_THAT(large, HasSubstr("180 m"));
  EXPECT_THAT(large, HasSubstr("--scale 0.001"));
  EXPECT_THAT(CheckPartSize("b.obj", Cube(1.8e-4)).error().detail, HasSubstr("0.00018 m"));
}

TEST(PartSize, ComparesTheTwoOfAPair) {
  EXPECT_TRUE(CheckSameUnit("a.obj", Cube(2.0), "b.obj", Cube(0.01)));
  const std::string error = CheckSameUnit("a.obj", Cube(0.02), "b.obj", Cube(16.0)).error().detail;
  EXPECT_EQ(error.find("b.obj"), 0U);
  EXPECT_THAT(error, HasSubstr("16 m"));
  EXPECT_THAT(error, HasSubstr("a.obj is 0.02 m"));
}

}  // namespace
}  // namespace vps
