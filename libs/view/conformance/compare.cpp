#include "view/conformance/compare.hpp"

#include <algorithm>

namespace view {
namespace {

bool IsInside(const picture::Measured<std::uint16_t>& ids, int x, int y) {
  if (x < 1 || y < 1 || x + 1 >= ids.width || y + 1 >= ids.height) return false;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (*ids.Pixel(x + dx, y + dy) != *ids.Pixel(x, y)) return false;
    }
  }
  return true;
}

double Share(int part, int all) {
  return all == 0 ? 1.0 : static_cast<double>(part) / all;
}

}  // namespace

Agreement Compare(const Rendering& reference, const Rendering& test) {
  int same = 0, inside = 0, same_inside = 0;
  picture::Measured<std::uint16_t> objects(reference.ids.width, reference.ids.height);
  for (int y = 0; y < objects.height; ++y) {
    for (int x = 0; x < objects.width; ++x) {
      const std::uint16_t a = *reference.ids.Pixel(x, y), b = *test.ids.Pixel(x, y);
      objects.values[static_cast<std::size_t>(y * objects.width + x)] = std::max(a, b);
      same += a == b ? 1 : 0;
      if (!IsInside(reference.ids, x, y)) continue;
      ++inside;
      same_inside += a == b ? 1 : 0;
    }
  }
  return {Share(same, objects.width * objects.height), Share(same_inside, inside),
          picture::Mean(picture::Flip(reference.image, test.image), objects)};
}

}  // namespace view
