#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "tracking/dtrack.hpp"

namespace tracking {

// Angles [rad] of the joints of a person's fingers: thumb, index, middle, ring, little; three for each, from the palm
// outwards. The thumb's first is its opposition, from beside the palm to before the fingers; all others flex, and 0 is
// a straight finger.
constexpr std::size_t kNumFingerAngles = 15;
using FingerAngles = std::array<double, kNumFingerAngles>;

// Of a hand that DTrack tracks, whose line has for each finger the angles between its phalanges and the pose of its
// tip. With the angle phi of the outer phalanx against the back of the hand, in the plane of the finger:
//   flexion of the knuckle = phi - (outer to middle) - (middle to inner).
// ART does not publish which axes it takes in a finger's frame. Assumed: x of the tip along the outer phalanx, x of the
// hand along its fingers, z out of its back. The opposition of the thumb is the angle of its tip about x of the hand.
// With three fingers, ring and little go with the middle one. None: it has no thumb and index finger.
std::optional<FingerAngles> AnglesOf(const TrackedHand& hand);

// Of a person who holds something of that width between the pads of thumb and fingers, for the hand of
// scenarios/parts/hand.py: the pads are parallel and that far apart. Less than the width of what is between them: they
// press.
FingerAngles GraspAngles(double opening_m);

}  // namespace tracking
