#pragma once

namespace tracking {

// A grip by a hand that is tracked and has no motor: where the jaws of the scene go in the person's place. The three
// methods of the paper, section 4, "Pseudo-Haptic Feedback".

constexpr double kMaxGrip_N = 40.0;                // assumed, of a person's two fingers, with the stick all down
constexpr double kGripStiffness_N_per_m = 3000.0;  // assumed: 30 N are 10 mm of the fingers' way

// What the person wants of the jaws: to be as far apart, and, where something is between them, to press with a force.
struct GripWish {
  double opening_m = 0.0;
  double force_N = 0.0;
};

// By a stick that springs back to its middle, s = -1 (drawn down) to 1 (up): up opens, opening = max s; in the middle
// the jaws are closed and do not press; down they press, F = max_N |s|.
GripWish WishOfStick(double stick, double opening_max_m, double max_N);

// By the way w between the tips of thumb and finger. What is held stops the jaws at o, the fingers go on: F =
// stiffness (o - w), at most max_N.
GripWish WishOfDistance(double fingers_m, double opening_m, double opening_max_m, double stiffness_N_per_m,
                        double max_N);

// By how strongly thumb and fingers are pinched, 0 to 1: F = max_N p. The fingers are `fingers_m` apart.
GripWish WishOfPinch(double pinch, double fingers_m, double opening_max_m, double max_N);

// The jaws. They follow the wish at kSpeed while nothing is between them. On something, which pushes them open with R,
//   b do/dt = R - F,
// so that they press with F whatever is as wide, and give way where F is less. R is late: it comes by way of
// haptic_node, k (o_held - o) of a time T ago. The loop do/dt = k (o_held - o(t - T)) / b settles without overshoot
// while k T / b <= 1/e, and at all while k T / b < pi / 2. With the jaws' k of 8 kN/m (scene::Coupling) and T = 3 ms,
// b = e k T = 65 N s/m; the second bound is then at T = 13 ms.
class PseudoJaws {
 public:
  PseudoJaws(double opening_max_m, double opening_m);

  // After a time: where they are. `reaction_N`: on them, positive opens.
  double Step(const GripWish& wish, double reaction_N, double dt_s) noexcept;

  [[nodiscard]] double opening_m() const { return opening_m_; }
  [[nodiscard]] bool is_on_something() const { return is_on_something_; }

  static constexpr double kDamping_N_s_per_m = 65.0;
  static constexpr double kSpeed_m_per_s = 0.1;  // of two fingers that close gently; chosen
  static constexpr double kTouch_N = 0.1;        // as much is contact

 private:
  double opening_max_m_, opening_m_;
  bool is_on_something_ = false;  // since it was closed on it, until it is opened
};

}  // namespace tracking
