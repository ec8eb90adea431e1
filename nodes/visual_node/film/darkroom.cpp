#include "nodes/visual_node/film/darkroom.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "vps/mesh/wide_clones.hpp"

namespace visual_node {
namespace {

// As in film_shaders.hpp, in codes of eight bits.
constexpr int kLeastContrast = 10;  // 0.04 of 255, rounded down: differences are whole numbers
constexpr int kContrast = 8;        // 1 / 0.125
constexpr float kReach_px = 8.0f;

#define ALWAYS_INLINE inline __attribute__((always_inline))

// 16 bits as float: their exponent is lower by 112.
ALWAYS_INLINE float ToFloat(std::uint16_t half) {
  const std::uint32_t bits = (half & 0x7fffu) << 13;
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(std::bit_cast<float>(bits) * 0x1p112f) | (half & 0x8000u)
                                                                                                        << 16);
}

// 0 to 1.
ALWAYS_INLINE float EncodeSrgb(float linear) {
  const float root2 = std::sqrt(linear);
  const float root4 = std::sqrt(root2);
  const float encoded =
      0.64236326f * root2 + 0.71211306f * root4 - 0.33687100f * std::sqrt(root4) - 0.01756217f * linear;
  return linear > 0.0031308f ? encoded : 12.92f * linear;
}

ALWAYS_INLINE std::uint32_t Code(float share) {
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(255.0f * share + 0.5f));
}

VPS_WIDE_CLONES void ReadRow(const std::uint16_t* light, int width, float* row) {
  for (int k = 0; k < 4 * width; ++k) row[k] = ToFloat(light[k]);
}

VPS_WIDE_CLONES void DevelopRow(const float* row, int width, float exposure, std::uint32_t* codes,
                                std::uint8_t* lumas) {
  for (int x = 0; x < width; ++x) {
    float r = exposure * row[4 * x], g = exposure * row[4 * x + 1], b = exposure * row[4 * x + 2];
    const float least = std::min(r, std::min(g, b));
    const float offset = least < 0.08f ? least - 6.25f * least * least : 0.04f;
    r -= offset;
    g -= offset;
    b -= offset;
    const float peak = std::max(r, std::max(g, b));
    const float new_peak = 1.0f - 0.0576f / (std::max(peak, 0.76f) - 0.52f);
    const bool is_low = peak < 0.76f;
    const float white = is_low ? 0.0f : 1.0f - 1.0f / (0.15f * (peak - new_peak) + 1.0f);
    const float scale = is_low ? 1.0f : (1.0f - white) * (new_peak / std::max(peak, 0.76f));
    const float added = white * new_peak;
    r = EncodeSrgb(std::min(std::max(r * scale + added, 0.0f), 1.0f));
    g = EncodeSrgb(std::min(std::max(g * scale + added, 0.0f), 1.0f));
    b = EncodeSrgb(std::min(std::max(b * scale + added, 0.0f), 1.0f));
    const float alpha = std::min(std::max(row[4 * x + 3], 0.0f), 1.0f);
    const std::uint32_t luma = Code((0.299f * r + 0.587f * g + 0.114f * b) * alpha);
    codes[x] = Code(r) | Code(g) << 8 | Code(b) << 16 | luma << 24;
    lumas[x] = static_cast<std::uint8_t>(luma);
  }
}

// Of a row of pixels: `lumas` of the pixel at the left in the row below, of which the next rows are `stride` farther.
VPS_WIDE_CLONES void FindEdges(const std::uint8_t* lumas, std::ptrdiff_t stride, int width, std::uint8_t* is_edge) {
  const std::uint8_t *below = lumas, *here = lumas + stride, *above = lumas + 2 * stride;
  for (int x = 0; x < width; ++x) {
    const std::uint8_t sw = below[x], se = below[x + 2], nw = above[x], ne = above[x + 2], centre = here[x + 1];
    const std::uint8_t low = std::min(std::min(std::min(nw, ne), std::min(sw, se)), centre);
    const std::uint8_t high = std::max(std::max(std::max(nw, ne), std::max(sw, se)), centre);
    const auto contrast = static_cast<std::uint8_t>(high - low);
    is_edge[x] = static_cast<std::uint8_t>((contrast > kLeastContrast) & (contrast > high / kContrast));
  }
}

ALWAYS_INLINE glm::vec4 Unpack(std::uint32_t code) {
  return {static_cast<float>(code & 255u), static_cast<float>(code >> 8 & 255u), static_cast<float>(code >> 16 & 255u),
          static_cast<float>(code >> 24)};
}

// At a place in pixels, whole numbers at their centres; mixed between four pixels.
glm::vec4 Sample(std::span<const std::uint32_t> codes, const glm::ivec2& size, const glm::vec2& place) {
  const glm::vec2 at = glm::clamp(place, glm::vec2(0.0f), glm::vec2(size - 1));
  const glm::ivec2 low(at), high = glm::min(low + 1, size - 1);
  const glm::vec2 share = at - glm::vec2(low);
  const auto pixel = [&](int x, int y) { return Unpack(codes[static_cast<std::size_t>(y * size.x + x)]); };
  return glm::mix(glm::mix(pixel(low.x, low.y), pixel(high.x, low.y), share.x),
                  glm::mix(pixel(low.x, high.y), pixel(high.x, high.y), share.x), share.y);
}

// A pixel of two, `share` of 256 of the second.
ALWAYS_INLINE std::uint32_t Mix(std::uint32_t a, std::uint32_t b, std::uint32_t share) {
  constexpr std::uint32_t kEverySecond = 0x00ff00ff, kHalf = 0x00800080;
  const std::uint32_t rest = 256 - share;
  const std::uint32_t even = ((a & kEverySecond) * rest + (b & kEverySecond) * share + kHalf) >> 8 & kEverySecond;
  const std::uint32_t odd = ((a >> 8 & kEverySecond) * rest + (b >> 8 & kEverySecond) * share + kHalf) & ~kEverySecond;
  return even | odd;
}

VPS_WIDE_CLONES void MixRows(const std::uint32_t* a, const std::uint32_t* b, std::uint32_t share, int width,
                             std::uint32_t* to) {
  for (int x = 0; x < width; ++x) to[x] = Mix(a[x], b[x], share);
}

// Where the middle of a pixel of a line of `many` lies on one of `few`: the pixels around it, and the second's share.
struct Between {
  int low = 0, high = 0;
  std::uint32_t share = 0;  // of 256
};
Between PlaceOn(int pixel, int many, int few) {
  const double place = std::clamp((pixel + 0.5) * few / many - 0.5, 0.0, few - 1.0);
  const int low = static_cast<int>(place);
  return {low, std::min(low + 1, few - 1), static_cast<std::uint32_t>(std::lround(256.0 * (place - low)))};
}

}  // namespace

std::optional<float> MeanLuminanceOf(std::span<const std::uint16_t> light, const glm::ivec2& film,
                                     const glm::ivec2& cells) {
  constexpr int kSide = 4;  // of a cell's samples
  const glm::vec2 step = glm::vec2(film) / glm::vec2(kSide * cells);
  float sum = 0.0f, number = 0.0f;
  for (int y = 0; y < kSide * cells.y; ++y) {
    const int row = static_cast<int>((static_cast<float>(y) + 0.5f) * step.y);
    for (int x = 0; x < kSide * cells.x; ++x) {
      const int column = static_cast<int>((static_cast<float>(x) + 0.5f) * step.x);
      const std::uint16_t* const at = &light[static_cast<std::size_t>(4 * (row * film.x + column))];
      if (ToFloat(at[3]) < 0.5f) continue;
      const glm::vec3 color(ToFloat(at[0]), ToFloat(at[1]), ToFloat(at[2]));
      sum += std::log2(std::max(glm::dot(color, glm::vec3(0.2126f, 0.7152f, 0.0722f)), 1e-3f));
      number += 1.0f;
    }
  }
  if (number == 0.0f) return std::nullopt;
  return std::exp2(sum / number);
}

std::span<const std::uint32_t> Darkroom::Develop(std::span<const std::uint16_t> light, const glm::ivec2& film,
                                                 float exposure, const glm::ivec2& target) {
  const auto width = static_cast<std::size_t>(film.x), height = static_cast<std::size_t>(film.y);
  const std::size_t stride = width + 2;
  row_.resize(4 * width);
  developed_.resize(width * height);
  lumas_.resize(stride * (height + 2));
  for (std::size_t y = 0; y < height; ++y) {
    std::uint8_t* const lumas = &lumas_[(y + 1) * stride];
    ReadRow(&light[4 * width * y], film.x, row_.data());
    DevelopRow(row_.data(), film.x, exposure, &developed_[width * y], lumas + 1);
    lumas[0] = lumas[1];
    lumas[width + 1] = lumas[width];
  }
  std::copy_n(&lumas_[stride], stride, lumas_.data());
  std::copy_n(&lumas_[height * stride], stride, &lumas_[(height + 1) * stride]);
  Smooth(film);
  if (film == target) return smoothed_;
  Enlarge(film, target);
  return enlarged_;
}

void Darkroom::Smooth(const glm::ivec2& film) {
  const auto width = static_cast<std::size_t>(film.x);
  const std::size_t stride = width + 2;
  smoothed_.resize(developed_.size());
  is_edge_.assign((width + 7) / 8 * 8, 0);
  for (int y = 0; y < film.y; ++y) {
    const std::uint8_t* const lumas = &lumas_[static_cast<std::size_t>(y) * stride];
    const std::uint32_t* const from = &developed_[static_cast<std::size_t>(y) * width];
    std::uint32_t* const to = &smoothed_[static_cast<std::size_t>(y) * width];
    for (std::size_t x = 0; x < width; ++x) to[x] = from[x] | 0xff000000u;
    FindEdges(lumas, static_cast<std::ptrdiff_t>(stride), film.x, is_edge_.data());
    for (std::size_t first = 0; first < width; first += 8) {
      std::uint64_t any = 0;
      std::memcpy(&any, &is_edge_[first], sizeof any);
      if (any == 0) continue;
      for (std::size_t x = first; x < std::min(first + 8, width); ++x) {
        if (is_edge_[x] == 0) continue;
        const float sw = lumas[x], se = lumas[x + 2], nw = lumas[x + 2 * stride], ne = lumas[x + 2 * stride + 2];
        const float centre = lumas[x + stride + 1];
        const float low = std::min({nw, ne, sw, se, centre}), high = std::max({nw, ne, sw, se, centre});
        glm::vec2 along(nw + ne - sw - se, nw + sw - ne - se);
        const float flat_part = std::max(0.03125f * (nw + ne + sw + se), 255.0f * 0.0078125f);
        along = glm::clamp(along / (std::min(std::abs(along.x), std::abs(along.y)) + flat_part), -kReach_px, kReach_px);
        const glm::vec2 here(static_cast<float>(x), static_cast<float>(y));
        const auto at = [&](float share) { return Sample(developed_, film, here + share * along); };
        const glm::vec4 two = 0.5f * (at(-1.0f / 6.0f) + at(1.0f / 6.0f));
        const glm::vec4 four = 0.5f * two + 0.25f * (at(-0.5f) + at(0.5f));
        const glm::uvec4 code((four.a < low || four.a > high ? two : four) + 0.5f);
        to[x] = code.r | code.g << 8 | code.b << 16 | 0xff000000u;
      }
    }
  }
}

void Darkroom::Enlarge(const glm::ivec2& film, const glm::ivec2& target) {
  const auto width = static_cast<std::size_t>(target.x);
  enlarged_.resize(width * static_cast<std::size_t>(target.y));
  std::vector<Between> columns;
  for (int x = 0; x < target.x; ++x) columns.push_back(PlaceOn(x, target.x, film.x));
  int have[2] = {-1, -1};  // which rows of the film are in wide_rows_
  const auto widen = [&](int y) -> const std::uint32_t* {
    std::vector<std::uint32_t>& wide = wide_rows_[y & 1];
    wide.resize(width);
    if (std::exchange(have[y & 1], y) == y) return wide.data();
    const std::uint32_t* const row = &smoothed_[static_cast<std::size_t>(y) * static_cast<std::size_t>(film.x)];
    for (std::size_t x = 0; x < width; ++x) wide[x] = Mix(row[columns[x].low], row[columns[x].high], columns[x].share);
    return wide.data();
  };
  for (int y = 0; y < target.y; ++y) {
    const Between rows = PlaceOn(y, target.y, film.y);
    const std::uint32_t* const low = widen(rows.low);
    const std::uint32_t* const high = widen(rows.high);
    MixRows(low, high, rows.share, target.x, &enlarged_[static_cast<std::size_t>(y) * width]);
  }
}

}  // namespace visual_node
