#include "nodes/visual_node/draw/label_places.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace visual_node {
namespace {

constexpr glm::dvec2 kPicture{640.0, 360.0};
constexpr double kGap = 8.0;

std::vector<Box> Place(const std::vector<WantedLabel>& labels, const std::vector<Stroke>& strokes = {},
                       const std::vector<Box>& taken = {}) {
  return PlaceLabels(labels, strokes, taken, kPicture, kGap);
}

bool Overlap(const Box& a, const Box& b) {
  return a.low.x < b.high.x && b.low.x < a.high.x && a.low.y < b.high.y && b.low.y < a.high.y;
}

TEST(LabelPlaces, AStrokeWithinABoxIsAsLongAsItsPartInside) {
  const Box box{{10.0, 10.0}, {20.0, 30.0}};
  EXPECT_DOUBLE_EQ(LengthWithin(box, {{0.0, 20.0}, {100.0, 20.0}}), 10.0);
  EXPECT_DOUBLE_EQ(LengthWithin(box, {{15.0, 12.0}, {15.0, 18.0}}), 6.0);
  EXPECT_NEAR(LengthWithin(box, {{5.0, 5.0}, {40.0, 40.0}}), 10.0 * std::sqrt(2.0), 1e-12);
  EXPECT_DOUBLE_EQ(LengthWithin(box, {{0.0, 5.0}, {100.0, 5.0}}), 0.0);
  EXPECT_DOUBLE_EQ(LengthWithin(box, {{0.0, 30.0}, {9.0, 20.0}}), 0.0);
}

TEST(LabelPlaces, ALabelStandsAboveItsPointWhereNothingIsInTheWay) {
  const Box box = Place({{{300.0, 200.0}, {80.0, 20.0}}}).front();
  EXPECT_DOUBLE_EQ(0.5 * (box.low.x + box.high.x), 300.0);
  EXPECT_DOUBLE_EQ(box.high.y, 200.0 - kGap);
  EXPECT_EQ(glm::length(LeaderOf(box, {300.0, 200.0}, kGap).to - LeaderOf(box, {300.0, 200.0}, kGap).from), 0.0);
}

TEST(LabelPlaces, ALabelKeepsClearOfAnArrowInAnyDirection) {
  for (int k = 0; k < 24; ++k) {
    const glm::dvec2 at(300.0, 200.0);
    const double angle = k * std::acos(-1.0) / 12.0;
    const Stroke arrow{at, at + 60.0 * glm::dvec2(std::cos(angle), std::sin(angle))};
    const Box box = Place({{at, {80.0, 20.0}}}, {arrow}).front();
    EXPECT_EQ(LengthWithin(box, arrow), 0.0) << k;
    EXPECT_FALSE(Overlap(box, {at, at})) << k;
  }
}

TEST(LabelPlaces, LabelsOfOnePlaceDoNotCoverEachOtherNorCaptions) {
  const std::vector<Box> taken = {{{0.0, 290.0}, {640.0, 360.0}}, {{0.0, 0.0}, {250.0, 80.0}}};
  for (const glm::dvec2 at : {glm::dvec2(300.0, 200.0), glm::dvec2(5.0, 90.0), glm::dvec2(630.0, 285.0)}) {
    const std::vector<Box> boxes = Place(std::vector<WantedLabel>(6, {at, {110.0, 20.0}}), {}, taken);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      EXPECT_TRUE(boxes[i].low.x >= kGap && boxes[i].low.y >= kGap);
      EXPECT_TRUE(boxes[i].high.x <= 640.0 - kGap && boxes[i].high.y <= 360.0 - kGap);
      for (std::size_t k = 0; k < i; ++k) EXPECT_FALSE(Overlap(boxes[i], boxes[k])) << i << " " << k;
      for (const Box& caption : taken) EXPECT_FALSE(Overlap(boxes[i], caption)) << i;
    }
  }
}

TEST(LabelPlaces, ALineLeadsFromALabelThatStandsApartToItsPoint) {
  const Stroke leader = LeaderOf({{100.0, 100.0}, {180.0, 120.0}}, {140.0, 200.0}, kGap);
  EXPECT_EQ(leader.from, glm::dvec2(140.0, 120.0));
  EXPECT_EQ(leader.to, glm::dvec2(140.0, 200.0));
}

}  // namespace
}  // namespace visual_node
