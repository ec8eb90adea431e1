#include "tracking/pseudo_grip.hpp"

#include <algorithm>

namespace tracking {

GripWish WishOfStick(double stick, double opening_max_m, double max_N) {
  const double s = std::clamp(stick, -1.0, 1.0);
  return {opening_max_m * std::max(0.0, s), max_N * std::max(0.0, -s)};
}

GripWish WishOfDistance(double fingers_m, double opening_m, double opening_max_m, double stiffness_N_per_m,
                        double max_N) {
  const double wanted_m = std::clamp(fingers_m, 0.0, opening_max_m);
  return {wanted_m, std::clamp(stiffness_N_per_m * (opening_m - wanted_m), 0.0, max_N)};
}

GripWish WishOfPinch(double pinch, double fingers_m, double opening_max_m, double max_N) {
  return {std::clamp(fingers_m, 0.0, opening_max_m), max_N * std::clamp(pinch, 0.0, 1.0)};
}

PseudoJaws::PseudoJaws(double opening_max_m, double opening_m) : opening_max_m_(opening_max_m), opening_m_(opening_m) {}

double PseudoJaws::Step(const GripWish& wish, double reaction_N, double dt_s) noexcept {
  const double way_m = wish.opening_m - opening_m_;
  is_on_something_ = way_m < 0.0 && (is_on_something_ || reaction_N >= kTouch_N);
  const double fastest_m = kSpeed_m_per_s * dt_s;
  const double step_m = is_on_something_ ? (reaction_N - wish.force_N) / kDamping_N_s_per_m * dt_s : way_m;
  opening_m_ = std::clamp(opening_m_ + std::clamp(step_m, -fastest_m, fastest_m), 0.0, opening_max_m_);
  return opening_m_;
}

}  // namespace tracking
