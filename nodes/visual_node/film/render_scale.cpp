#include "nodes/visual_node/film/render_scale.hpp"

#include <algorithm>
#include <cmath>

namespace visual_node {

void RenderScale::Update(double picture_s) {
  pictures_s_[num_pictures_] = picture_s;
  if (++num_pictures_ < kWindow) return;
  num_pictures_ = 0;
  const auto middle = pictures_s_.begin() + kWindow / 2;
  std::nth_element(pictures_s_.begin(), middle, pictures_s_.end());
  const auto fitting = [&](double time_s) { return static_cast<int>(step_ * std::sqrt(time_s / *middle)); };
  if (*middle > budget_s_) {
    step_ = std::max(kLeastSteps, std::min(fitting(budget_s_), step_ - 1));
  } else {
    step_ = std::clamp(fitting(kReserve * budget_s_), step_, kMostSteps);
  }
}

}  // namespace visual_node
