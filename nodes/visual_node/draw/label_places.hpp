#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace visual_node {

// Pixels from the top left corner of a picture.
struct Box {
  glm::dvec2 low{0.0};  // its corner at the top left
  glm::dvec2 high{0.0};

  [[nodiscard]] glm::dvec2 size() const { return high - low; }
};

// What labels keep clear of where they can: the axis of an arrow, a piece of a ring.
struct Stroke {
  glm::dvec2 from{0.0};
  glm::dvec2 to{0.0};
};

struct WantedLabel {
  glm::dvec2 at{0.0};  // the place that it names
  glm::dvec2 size{0.0};
  double clear = 0.0;  // how far around its place it leaves all to be seen
};

// The length of a stroke that is inside of a box.
double LengthWithin(const Box& box, const Stroke& stroke);

// A box for each label, in this order: of the places around its point, near ones first and the one above before all
// others, that which hides least. What it may not hide are the labels before it and `taken`; strokes it should not
// hide. `gap`: between a label and its point, and to the picture's edge.
std::vector<Box> PlaceLabels(std::span<const WantedLabel> labels, std::span<const Stroke> strokes,
                             std::span<const Box> taken, const glm::dvec2& picture, double gap);

// From a label to its point, where the label stands apart from it; of no length where it does not.
Stroke LeaderOf(const Box& label, const glm::dvec2& at, double gap);

}  // namespace visual_node
