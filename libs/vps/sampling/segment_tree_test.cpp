#include "vps/sampling/segment_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace vps {
namespace {

using Segments = std::vector<std::array<glm::dvec3, 2>>;

class Random {
 public:
  double Number() { return static_cast<double>(engine_() >> 11) * 0x1p-53 * 2.0 - 1.0; }
  glm::dvec3 Place() { return {Number(), Number(), Number()}; }

 private:
  std::mt19937_64 engine_{11};
};

// Short and long ones, and points.
Segments MakeSegments(std::size_t count, Random* random) {
  Segments segments;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3 a = random->Place();
    segments.push_back({a, a + (i % 3 == 0 ? 0.0 : i % 3 == 1 ? 0.02 : 0.5) * random->Place()});
  }
  return segments;
}

double Distance(const std::array<glm::dvec3, 2>& segment, const glm::dvec3& p) {
  const glm::dvec3 along = segment[1] - segment[0];
  const double squared = glm::dot(along, along);
  const double t = squared > 0.0 ? std::clamp(glm::dot(p - segment[0], along) / squared, 0.0, 1.0) : 0.0;
  return glm::length(p - (segment[0] + t * along));
}

double LeastDistance(const Segments& segments, const glm::dvec3& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& segment : segments) least = std::min(least, Distance(segment, p));
  return least;
}

// Whether few are listed or many are looked for in the tree, the answer is that of a search of all.
TEST(SegmentTree, FindsTheNearestOfFewAndOfMany) {
  Random random;
  for (const std::size_t count : {0, 1, 20, 3000}) {
    const Segments segments = MakeSegments(count, &random);
    const SegmentTree tree(segments);
    const SegmentTree::Nearby all = tree.Around({glm::dvec3(-9.0), glm::dvec3(9.0)});
    EXPECT_EQ(all.is_listed, count <= 20);
    for (int i = 0; i < 300; ++i) {
      const glm::dvec3 p = 1.5 * random.Place();
      const double distance = tree.Distance_m(p, all, 10.0, 10.0);
      if (count == 0) {
        EXPECT_TRUE(std::isinf(distance));
      } else {
        EXPECT_NEAR(distance, LeastDistance(segments, p), 1e-12);
      }
    }
  }
}

// What is out of reach of one of the centres is left out, also where only a search of the tree can tell.
TEST(SegmentTree, LeavesOutWhatNarrowingLeftOut) {
  Random random;
  const Segments segments = MakeSegments(3000, &random);
  const SegmentTree tree(segments);
  const SegmentTree::Nearby all = tree.Around({glm::dvec3(-9.0), glm::dvec3(9.0)});
  int num_searched = 0;
  for (int i = 0; i < 200; ++i) {
    const glm::dvec3 first = random.Place();
    const glm::dvec3 second = first + 0.2 * random.Place();
    const SegmentTree::Nearby wide = tree.Narrow(all, first, 0.6);
    const SegmentTree::Nearby narrow = tree.Narrow(wide, second, i % 2 == 0 ? 0.5 : 0.1);
    Segments left;
    for (const auto& segment : segments) {
      if (Distance(segment, first) < 0.6 && Distance(segment, second) < (i % 2 == 0 ? 0.5 : 0.1))
        left.push_back(segment);
    }
    num_searched += narrow.is_listed ? 0 : 1;
    const glm::dvec3 p = second + random.Place();  // as likely outside the reaches as inside
    const double expected = LeastDistance(left, p);
    if (std::isinf(expected)) {
      EXPECT_TRUE(std::isinf(tree.Distance_m(p, narrow, 0.0, 10.0)));
    } else {
      EXPECT_NEAR(tree.Distance_m(p, narrow, 0.0, 10.0), expected, 1e-12);
    }
  }
  EXPECT_GT(num_searched, 50);
  EXPECT_LT(num_searched, 150);
}

}  // namespace
}  // namespace vps
