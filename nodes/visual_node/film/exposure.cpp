#include "nodes/visual_node/film/exposure.hpp"

#include <algorithm>
#include <cmath>

namespace visual_node {

// In logarithms, so that brighter and darker take equally long.
void Exposure::Update(std::optional<float> mean_luminance, double dt_s) {
  if (!mean_luminance) return;
  const float wanted = std::clamp(kGrey / std::max(*mean_luminance, 1e-6f), kLeast, kMost);
  const double share = 1.0 - std::exp(-std::max(dt_s, 0.0) / kTimeConstant_s);
  value_ *= static_cast<float>(std::pow(wanted / value_, share));
}

}  // namespace visual_node
