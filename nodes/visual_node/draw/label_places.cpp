#include "nodes/visual_node/draw/label_places.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace visual_node {
namespace {

// Costs, in pixels of distance from the point. A label goes four times as far as what it would hide of an arrow is
// long; over another text it stands only where no other place is left.
constexpr double kOfHiddenStroke = 4.0, kOfHiddenText = 100.0;

// Where the label's middle is, from its point, best first.
constexpr std::array<glm::dvec2, 8> kWays = {glm::dvec2{0, -1}, {1, -1}, {-1, -1}, {1, 0},
                                             {-1, 0},           {0, 1},  {1, 1},   {-1, 1}};
constexpr double kOfNextWay = 0.25;                                          // gaps
constexpr std::array<double, 6> kRings = {1.0, 3.0, 6.0, 10.0, 15.0, 22.0};  // gaps between the label and its point

Box Grown(const Box& box, double by) {
  return {box.low - by, box.high + by};
}

bool Contains(const Box& box, const glm::dvec2& p) {
  return p == glm::clamp(p, box.low, box.high);
}

double SharedArea(const Box& a, const Box& b) {
  const glm::dvec2 shared = glm::max(glm::min(a.high, b.high) - glm::max(a.low, b.low), 0.0);
  return shared.x * shared.y;
}

Box Inside(Box box, const glm::dvec2& picture, double gap) {
  const glm::dvec2 most = glm::max(picture - gap - box.size(), glm::dvec2(gap));
  const glm::dvec2 low = glm::clamp(box.low, glm::dvec2(gap), most);
  return {low, low + box.size()};
}

}  // namespace

// Liang and Barsky's clipping: the stroke is from + t (to - from), each side of the box bounds t.
double LengthWithin(const Box& box, const Stroke& stroke) {
  const glm::dvec2 way = stroke.to - stroke.from;
  double first = 0.0, last = 1.0;
  for (int k = 0; k < 2; ++k) {
    const double below = box.low[k] - stroke.from[k], above = box.high[k] - stroke.from[k];
    if (std::abs(way[k]) < 1e-12) {
      if (below > 0.0 || above < 0.0) return 0.0;
      continue;
    }
    first = std::max(first, std::min(below / way[k], above / way[k]));
    last = std::min(last, std::max(below / way[k], above / way[k]));
  }
  return std::max(last - first, 0.0) * glm::length(way);
}

std::vector<Box> PlaceLabels(std::span<const WantedLabel> labels, std::span<const Stroke> strokes,
                             std::span<const Box> taken, const glm::dvec2& picture, double gap) {
  std::vector<Box> full(taken.begin(), taken.end());
  std::vector<Box> placed;
  for (const WantedLabel& label : labels) {
    Box best;
    double least = std::numeric_limits<double>::max();
    for (const double ring : kRings) {
      for (const glm::dvec2& way : kWays) {
        const glm::dvec2 middle = label.at + way * (0.5 * label.size + label.clear + ring * gap);
        const Box box = Inside({middle - 0.5 * label.size, middle + 0.5 * label.size}, picture, gap);
        double cost = (ring + kOfNextWay * static_cast<double>(&way - kWays.data())) * gap;
        if (Contains(box, label.at)) cost += kOfHiddenText * gap;
        for (const Box& other : full) cost += kOfHiddenText * std::sqrt(SharedArea(box, other));
        for (const Stroke& stroke : strokes) cost += kOfHiddenStroke * LengthWithin(Grown(box, 0.5 * gap), stroke);
        if (cost >= least) continue;
        least = cost;
        best = box;
      }
    }
    full.push_back(best);
    placed.push_back(best);
  }
  return placed;
}

Stroke LeaderOf(const Box& label, const glm::dvec2& at, double gap) {
  const glm::dvec2 nearest = glm::clamp(at, label.low, label.high);
  if (glm::distance(nearest, at) < 1.5 * gap) return {at, at};
  return {nearest, at};
}

}  // namespace visual_node
