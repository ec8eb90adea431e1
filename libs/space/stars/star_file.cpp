#include "space/stars/star_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "core/read_file.hpp"

// The committed stars become part of the program, so that it needs no search for them.
// NOLINTBEGIN
asm(".pushsection .rodata\n"
    ".global vr_oos_bright_stars\n"
    ".global vr_oos_bright_stars_end\n"
    "vr_oos_bright_stars:\n"
    ".incbin \"" VR_OOS_BRIGHT_STARS
    "\"\n"
    "vr_oos_bright_stars_end:\n"
    ".byte 0\n"
    ".popsection\n");
extern "C" const std::uint8_t vr_oos_bright_stars[];
extern "C" const std::uint8_t vr_oos_bright_stars_end[];
// NOLINTEND

namespace space {
namespace {

constexpr std::string_view kMagic = "OOSSTAR1";
constexpr std::size_t kHeaderBytes = 12;
constexpr std::size_t kStarBytes = 9;
constexpr double kSteps = (1 << 24) - 1;

using Record = std::array<std::uint8_t, kStarBytes>;

double SignOf(double value) {
  return value < 0.0 ? -1.0 : 1.0;
}

glm::dvec2 Unfold(const glm::dvec3& d) {
  const glm::dvec2 p = glm::dvec2(d) / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
  if (d.z >= 0.0) return p;
  return {(1.0 - std::abs(p.y)) * SignOf(p.x), (1.0 - std::abs(p.x)) * SignOf(p.y)};
}

glm::dvec3 Fold(const glm::dvec2& p) {
  const double z = 1.0 - std::abs(p.x) - std::abs(p.y);
  if (z >= 0.0) return glm::normalize(glm::dvec3(p, z));
  return glm::normalize(glm::dvec3((1.0 - std::abs(p.y)) * SignOf(p.x), (1.0 - std::abs(p.x)) * SignOf(p.y), z));
}

// `value` in steps, rounded and limited to `num_bytes` bytes, little-endian.
void Put(double value, std::size_t num_bytes, std::uint8_t* to) {
  const double most = static_cast<double>((1U << (8 * num_bytes)) - 1U);
  const auto steps = static_cast<std::uint32_t>(std::clamp(std::floor(value + 0.5), 0.0, most));
  for (std::size_t i = 0; i < num_bytes; ++i) to[i] = static_cast<std::uint8_t>(steps >> (8 * i));
}

double Get(std::size_t num_bytes, const std::uint8_t* from) {
  std::uint32_t steps = 0;
  for (std::size_t i = 0; i < num_bytes; ++i) steps |= static_cast<std::uint32_t>(from[i]) << (8 * i);
  return steps;
}

Record Pack(const Star& star) {
  Record record{};
  const glm::dvec2 p = Unfold(star.direction_C);
  Put((0.5 * p.x + 0.5) * kSteps, 3, &record[0]);
  Put((0.5 * p.y + 0.5) * kSteps, 3, &record[3]);
  Put((star.magnitude + 2.0) * 1000.0, 2, &record[6]);
  Put((star.color_bv + 0.5) * 50.0, 1, &record[8]);
  return record;
}

Star Unpack(const std::uint8_t* from) {
  const glm::dvec2 p(Get(3, from), Get(3, from + 3));
  return {Fold(2.0 * p / kSteps - 1.0), Get(2, from + 6) / 1000.0 - 2.0, Get(1, from + 8) / 50.0 - 0.5};
}

}  // namespace

std::string EncodeStars(std::vector<Star> stars) {
  std::stable_sort(stars.begin(), stars.end(), [](const Star& a, const Star& b) { return a.magnitude < b.magnitude; });
  std::string bytes(kMagic);
  const auto count = static_cast<std::uint32_t>(stars.size());
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(count >> (8 * i));
  for (const Star& star : stars) {
    const Record record = Pack(star);
    bytes.append(record.begin(), record.end());
  }
  return bytes;
}

core::Result<std::vector<Star>> DecodeStars(std::span<const std::uint8_t> bytes) {
  const auto damaged = [](const char* why) {
    return core::Fail(core::ErrorCode::kDamaged, std::string("no star catalogue: ") + why);
  };
  if (bytes.size() < kHeaderBytes || std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0) {
    return damaged("it does not begin with OOSSTAR1");
  }
  const auto* at = bytes.data();
  const auto count = static_cast<std::size_t>(Get(4, at + kMagic.size()));
  if (bytes.size() != kHeaderBytes + count * kStarBytes) return damaged("its size is not that of its stars");
  std::vector<Star> stars;
  stars.reserve(count);
  for (std::size_t i = 0; i < count; ++i) stars.push_back(Unpack(at + kHeaderBytes + i * kStarBytes));
  return stars;
}

std::span<const std::uint8_t> BrightStarBytes() {
  return {vr_oos_bright_stars, vr_oos_bright_stars_end};
}

Catalogue LoadStars(const std::filesystem::path& full_file) {
  std::string why = "it is not built";
  std::error_code error;
  if (std::filesystem::exists(full_file, error)) {
    const auto bytes = core::ReadFile(full_file);
    auto stars = bytes ? DecodeStars(*bytes) : core::Result<std::vector<Star>>(tl::unexpected(bytes.error()));
    if (stars) return {std::move(*stars), ""};
    why = stars.error().detail;
  }
  auto bright = DecodeStars(BrightStarBytes());
  Catalogue catalogue;
  if (bright) catalogue.stars = std::move(*bright);
  catalogue.note = std::to_string(catalogue.stars.size()) + " stars; the full catalogue " + full_file.string() +
                   " is missing (" + why + "): `oos stars` builds it";
  return catalogue;
}

}  // namespace space
