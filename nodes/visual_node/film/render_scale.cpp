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
  constexpr int kLeastSteps = static_cast<int>(kLeast / kStep + 0.5);
  if (*middle > budget_s_) {
    const int fitting = static_cast<int>(step_ * std::sqrt(budget_s_ / *middle));
    step_ = std::max(kLeastSteps, std::min(fitting, step_ - 1));
  } else if (step_ < kMostSteps) {
    const double larger = (step_ + 1.0) / step_;
    if (*middle * larger * larger < kReserve * budget_s_) ++step_;
  }
}

}  // namespace visual_node
