#include "tracking/finger_angles.hpp"

#include <algorithm>
#include <cmath>

namespace tracking {
namespace {

// Of scenarios/parts/hand.py: where the first joint that flexes stands, from the plane between the pads, how long its
// link is, and how thick.
struct Root {
  double aside_m;
  double length_m;
  double radius_m;
};
constexpr Root kThumb{0.018, 0.045, 0.009};
constexpr Root kFinger{0.018, 0.045, 0.008};
constexpr double kOpposed_rad = 1.1118;  // 63.7 degrees: the thumb before the fingers

// The first link turns by q from where it is parallel to the plane between the pads, and the next joint turns back by
// as much, so that the links beyond are parallel to that plane at the distance d = aside - length sin q - radius.
double FlexionFor(const Root& root, double d_m) {
  return std::asin(std::clamp((root.aside_m - root.radius_m - d_m) / root.length_m, -1.0, 1.0));
}

void SetFinger(const TrackedFinger& finger, std::size_t number, FingerAngles* angles_rad) {
  const glm::dvec3 x_B = finger.X_BF.rotate({1.0, 0.0, 0.0});
  const double outer = finger.outer_middle_rad;
  const double middle = finger.middle_inner_rad;
  double* const joints = angles_rad->data() + 3 * number;
  if (number == 0) {
    const glm::dvec3& tip_B = finger.X_BF.translation;
    joints[0] = std::atan2(-tip_B.z, std::abs(tip_B.y));
    joints[1] = middle;
    joints[2] = outer;
    return;
  }
  joints[0] = std::atan2(-x_B.z, x_B.x) - outer - middle;
  joints[1] = middle;
  joints[2] = outer;
}

}  // namespace

std::optional<FingerAngles> AnglesOf(const TrackedHand& hand) {
  if (hand.fingers.size() < 2) return std::nullopt;
  FingerAngles angles_rad{};
  for (std::size_t i = 0; i < 5; ++i) {
    SetFinger(hand.fingers[std::min(i, hand.fingers.size() - 1)], i, &angles_rad);
  }
  return angles_rad;
}

FingerAngles GraspAngles(double opening_m) {
  FingerAngles angles_rad{};
  angles_rad[0] = kOpposed_rad;
  angles_rad[1] = FlexionFor(kThumb, 0.5 * opening_m);
  angles_rad[2] = -angles_rad[1];
  for (std::size_t finger = 1; finger < 5; ++finger) {
    angles_rad[3 * finger] = FlexionFor(kFinger, 0.5 * opening_m);
    angles_rad[3 * finger + 1] = -angles_rad[3 * finger];
  }
  return angles_rad;
}

}  // namespace tracking
