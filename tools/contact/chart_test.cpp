#include "tools/contact/chart.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace contact {
namespace {

using testing::HasSubstr;

TEST(Chart, PlacesPointsOnLogarithmicAxes) {
  Chart chart{"times & errors",
              {{"error", "us", {{"paper", {{1.0, 0.1, "low"}, {10.0, 1.0, "mid"}, {100.0, 10.0, "high"}}}}}}};
  const std::string svg = DrawSvg(chart);
  EXPECT_THAT(svg, HasSubstr("times &amp; errors"));
  // Plot from x = 62 to 416 and y = 88 to 274: the middle decade is in the middle.
  EXPECT_THAT(svg, HasSubstr("cx='62.0' cy='274.0'"));
  EXPECT_THAT(svg, HasSubstr("cx='239.0' cy='181.0'"));
  EXPECT_THAT(svg, HasSubstr("cx='416.0' cy='88.0'"));
}

TEST(Chart, DrawsAnErrorOfZeroAtTheBorder) {
  Chart chart{"t", {{"error", "us", {{"a", {{1.0, 0.0, "exact"}, {10.0, 1.0, "off"}}}}}}};
  EXPECT_THAT(DrawSvg(chart), HasSubstr("cx='62.0' cy='274.0'"));
}

}  // namespace
}  // namespace contact
