#include "vps/field/mean_depths.hpp"

#include <algorithm>
#include <cmath>

namespace vps {

void ComputeMeanDepths(DistanceField* field) {
  const int shift = field->coarse_shift;
  const glm::ivec3 n(field->nx >> shift, field->ny >> shift, field->nz >> shift);
  const auto side = static_cast<float>(1 << shift);
  const std::size_t steps[3] = {1, static_cast<std::size_t>(n.x), static_cast<std::size_t>(n.x) * n.y};
  const std::vector<CoarseCell> at_centres = field->coarse;
  // The border around a solid is outside.
  for (std::size_t i = steps[2]; i + steps[2] < at_centres.size(); ++i) {
    const float d = at_centres[i].distance;
    if (!(d < 0.0f)) continue;
    // Over a cube of side a, sum_k d_kk x_k^2 / 2 is sum_k d_kk a^2 / 24 in the mean, and d_kk a^2 is about the second
    // difference of the centres' values. Where an edge of the medial axis goes through, that is right in the mean over
    // where it may lie: a kink by 2 in the slope at t from the centre lifts the mean by (a / 2 - |t|)^2 / a and the
    // second difference / 24 by (a - |t|) / 12, whose integrals over t are both a^2 / 12.
    float sum = 0.0f;
    for (const std::size_t step : steps) {
      const float before = at_centres[i - step].distance - d;
      const float after = at_centres[i + step].distance - d;
      // No distance changes by more than the step: larger differences come from a wrong sign.
      if (std::abs(before) <= side && std::abs(after) <= side) sum += before + after;
    }
    field->coarse[i].distance = std::min(d + sum / 24.0f, 0.0f);
  }
}

}  // namespace vps
