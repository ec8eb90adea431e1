#pragma once

#include <span>
#include <string>

namespace tracking {

// Of ART's Fingertracking Tactile: what a finger shall feel.
struct FingerVibration {
  int hand = 0;           // as in the line `gl`
  int finger = 0;         // 0: the thumb, to 4
  double strength = 0.0;  // 0 to 1; others are brought into it, what is not finite becomes 0
};

// The datagram for the controller's UDP port 50110 [ART, DTrack2 user manual, B.3.1]: "tfb n [hand finger depth
// strength] ...". The depth is 1, since motors multiply it with the strength. A controller stops the motors when it has
// heard nothing for some seconds, so it is to be repeated.
std::string TactileDatagram(std::span<const FingerVibration> fingers);

}  // namespace tracking
