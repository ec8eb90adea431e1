#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "space/stars/star.hpp"

namespace space {

// A star catalogue as bytes, brightest first: "OOSSTAR1", the number of stars (u32), then nine bytes for each star,
// little-endian: two u24, the direction on the unfolded octahedron [Cigolle et al. 2014] (off by at most 0.05 arc
// seconds); u16, (V + 2) 1000; u8, (B - V + 0.5) 50.
std::string EncodeStars(std::vector<Star> stars);
core::Result<std::vector<Star>> DecodeStars(std::span<const std::uint8_t> bytes);

// The 118216 stars that are part of the program (make_bright_stars.py).
std::span<const std::uint8_t> BrightStarBytes();

// A catalogue and where it comes from.
struct Catalogue {
  std::vector<Star> stars;
  std::string note;  // empty: all stars; else what is missing, and how to get it
};

// Where `oos stars` writes all stars, in the folder of caches.
constexpr const char* kFullCatalogueName = "tycho2.stars";

// All stars if `full_file` has them, or else the bright ones.
Catalogue LoadStars(const std::filesystem::path& full_file);

}  // namespace space
