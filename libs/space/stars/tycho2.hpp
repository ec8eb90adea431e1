#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/result.hpp"
#include "space/stars/star.hpp"

namespace space {

// The file of the Debian package astrometry-data-tycho2-07-littleendian (BSD-2): an index of astrometry.net in FITS
// that has places and VT magnitudes of 1.87 million stars of Tycho-2.
constexpr const char* kTycho2Package = "astrometry-data-tycho2-07-littleendian";
constexpr const char* kTycho2File = "/usr/share/astrometry/index-tycho2-07.littleendian.fits";

// Magnitudes become V with the colour of most stars, as the index has no colours.
core::Result<std::vector<Star>> ReadTycho2(std::span<const std::uint8_t> fits);

// Both lists as one. A bright star that lies within 30 arc seconds of one of Tycho-2, and within 1.5 magnitudes, is the
// same: place of Tycho-2, magnitude and colour of the bright list. The others are added, as Tycho-2 lacks some of the
// brightest.
struct MergedStars {
  std::vector<Star> stars;
  std::size_t num_same = 0;
};
MergedStars MergeStars(std::vector<Star> tycho2, std::span<const Star> bright);

}  // namespace space
