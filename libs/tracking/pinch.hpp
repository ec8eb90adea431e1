#pragma once

#include <optional>
#include <string_view>

namespace tracking {

// What a sensor of pinching says, as lines of ASCII, CR LF or LF at their ends:
//   pinch n [id f1 f2 f3 f4] ...
// n hands; of each its number in DTrack and how strongly its thumb and each finger are pressed together, 0 to 1. ART's
// sensor has no published format: this one is the project's own. Of that hand the strongest; none: it is not there, or
// a number is not one from 0 to 1. Any bytes are allowed.
std::optional<double> ParsePinch(std::string_view datagram, int hand);

}  // namespace tracking
