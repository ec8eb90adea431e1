#include "tools/bench/chart.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace bench {
namespace {

using testing::HasSubstr;

Panel MakePanel(std::vector<Series> series, bool is_log = true) {
  Panel panel;
  panel.title = "error";
  panel.x_title = "us";
  panel.y_title = "mm";
  panel.series = std::move(series);
  panel.x_log = panel.y_log = is_log;
  return panel;
}

ChartPoint At(double x, double y) {
  ChartPoint point;
  point.x = x;
  point.y = y;
  return point;
}

// The plot of a first panel spans x = 70 to 500 and y = 102 to 348.
TEST(Chart, PlacesPointsOnLogarithmicAxes) {
  const Chart chart{"times & errors", "", {MakePanel({{"paper", {At(1, 0.1), At(10, 1), At(100, 10)}, true}})}};
  const std::string svg = DrawSvg(chart);
  EXPECT_THAT(svg, HasSubstr("times &amp; errors"));
  EXPECT_THAT(svg, HasSubstr("cx='285.0' cy='225.0'"));  // the middle decade is in the middle
  EXPECT_THAT(svg, HasSubstr(">10</text>"));
}

TEST(Chart, WritesZeroWithoutASign) {
  const Chart chart{"t", "", {MakePanel({{"fast", {At(0, -0.03), At(1, 1)}, true}}, false)}};
  const std::string svg = DrawSvg(chart);
  EXPECT_THAT(svg, HasSubstr(">0</text>"));
  EXPECT_THAT(svg, testing::Not(HasSubstr(">-0</text>")));
}

TEST(Chart, PlacesPointsOnLinearAxesFromZero) {
  const Chart chart{"t", "", {MakePanel({{"fast", {At(0, 0), At(1, 1)}, true}}, false)}};
  EXPECT_THAT(DrawSvg(chart), HasSubstr("cx='70.0' cy='348.0'"));
}

TEST(Chart, DrawsAnErrorOfZeroAtTheBorder) {
  const Chart chart{"t", "", {MakePanel({{"a", {At(1, 0), At(10, 1)}, true}})}};
  EXPECT_THAT(DrawSvg(chart), HasSubstr("cy='348.0'"));
}

TEST(Chart, NamesEverySeriesBesideItsPoints) {
  const Chart chart{"t", "", {MakePanel({{"paper", {At(1, 1)}, true}, {"fast", {At(1, 1)}, true}})}};
  const std::string svg = DrawSvg(chart);
  EXPECT_THAT(svg, HasSubstr("font-weight='bold'>paper<"));
  EXPECT_THAT(svg, HasSubstr("font-weight='bold'>fast<"));
}

TEST(Chart, DrawsBarsWithTheirNotes) {
  Panel panel = MakePanel({}, false);
  panel.bars = {{"AVX2", 2.0, "2 us", "fast"}};
  EXPECT_THAT(DrawSvg({"t", "", {panel}}), HasSubstr(">2 us<"));
}

TEST(Chart, TintsABandUpToTheBorderAndKeepsTheGivenAxis) {
  Panel panel = MakePanel({{"a", {At(0, 1), At(1, 9)}, true}}, false);
  panel.y_low = 0.0;
  panel.y_high = 2.0;
  panel.bands = {{1.0, 1e9, "fails"}};
  const std::string svg = DrawSvg({"t", "", {panel}});
  EXPECT_THAT(svg, HasSubstr("<rect x='70.0' y='102.0' width='430.0' height='123.0' fill='#fbe3dd'/>"));
  EXPECT_THAT(svg, HasSubstr(">fails</text>"));
}

}  // namespace
}  // namespace bench
