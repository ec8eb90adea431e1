#pragma once

#include <optional>
#include <string_view>

#include "tracking/finger_angles.hpp"

namespace tracking {

// What data gloves say, as lines of ASCII, CR LF or LF at their ends:
//   glove n [id t0 t1 t2 i0 i1 i2 m0 m1 m2 r0 r1 r2 l0 l1 l2] ...
// n hands; of each its number in DTrack and the angles [rad] of thumb, index, middle, ring and little finger, as
// FingerAngles has them. The format is the project's own: docs/reference/glove_protocol.md. The angles of that hand;
// none: it is not there, a number is missing, or an angle is beyond half a turn. Any bytes are allowed.
std::optional<FingerAngles> ParseGlove(std::string_view datagram, int hand);

}  // namespace tracking
