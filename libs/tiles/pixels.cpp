#include "tiles/pixels.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace tiles {
namespace {

constexpr int kMantissaBits = 9, kBias = 15;
constexpr float kMostLight = 65408.0f;

template <class T>
void Append(std::string* bytes, T value) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof value);
}

// Reads a message; what it does not hold is none.
class Bytes {
 public:
  explicit Bytes(const std::string& bytes) : at_(bytes.data()), left_(bytes.size()) {}
  template <class T>
  bool Take(T* values, std::size_t count) {
    if (left_ < count * sizeof(T)) return false;
    std::memcpy(values, at_, count * sizeof(T));
    at_ += count * sizeof(T);
    left_ -= count * sizeof(T);
    return true;
  }
  [[nodiscard]] bool is_empty() const { return left_ == 0; }

 private:
  const char* at_;
  std::size_t left_;
};

// visit(first in the canvas, first in the run, count) for each row of the tile that pixels [begin, end) of it reach.
template <class Visit>
void EachRow(const Tile& tile, int stride, std::size_t begin, std::size_t end, Visit&& visit) {
  const auto width = static_cast<std::size_t>(tile.width);
  for (std::size_t at = begin; at < end;) {
    const std::size_t row = at / width, column = at % width;
    const std::size_t count = std::min(end - at, width - column);
    visit((static_cast<std::size_t>(tile.y) + row) * static_cast<std::size_t>(stride) +
              static_cast<std::size_t>(tile.x) + column,
          at - begin, count);
    at += count;
  }
}

}  // namespace

// The exponent is that of the brightest channel; one more where its mantissa would round up to 512.
std::uint32_t PackLight(const glm::vec3& light) {
  const glm::vec3 c(std::clamp(light.r, 0.0f, kMostLight), std::clamp(light.g, 0.0f, kMostLight),
                    std::clamp(light.b, 0.0f, kMostLight));
  const float most = std::max(c.r, std::max(c.g, c.b));
  const int exponent_of_most = static_cast<int>(std::bit_cast<std::uint32_t>(most) >> 23) - 127;
  int exponent = std::max(exponent_of_most, -kBias - 1) + 1 + kBias;
  const auto step_of = [](int e) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(127 + kBias + kMantissaBits - e) << 23);
  };
  float per_step = step_of(exponent);
  if (most * per_step + 0.5f >= 512.0f) per_step = step_of(++exponent);
  const auto code = [per_step](float x) { return static_cast<std::uint32_t>(x * per_step + 0.5f); };
  return code(c.r) | code(c.g) << 9 | code(c.b) << 18 | static_cast<std::uint32_t>(exponent) << 27;
}

glm::vec3 UnpackLight(std::uint32_t packed) {
  const float step = std::ldexp(1.0f, static_cast<int>(packed >> 27) - kBias - kMantissaBits);
  return step * glm::vec3(static_cast<float>(packed & 511u), static_cast<float>(packed >> 9 & 511u),
                          static_cast<float>(packed >> 18 & 511u));
}

std::uint16_t PackDepth(float depth_m) {
  if (!(depth_m > 0.0f)) return 0;
  static const float kPerLog = 65534.0f / std::log(kFarthest_m / kNearest_m);
  const float code = kPerLog * std::log(depth_m / kNearest_m);
  return static_cast<std::uint16_t>(1 + std::lround(std::clamp(code, 0.0f, 65534.0f)));
}

void Canvas::Resize(int new_width, int new_height) {
  width = new_width;
  height = new_height;
  const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  light.resize(count);
  depth.resize(count);
}

std::string EncodePixels(const Tile& tile, std::span<const float> light, std::span<const float> depth_m) {
  const auto count = static_cast<std::size_t>(tile.num_pixels());
  std::string bytes;
  bytes.reserve(6 * count + 64);
  for (std::size_t at = 0; at < count;) {
    std::size_t begin = at;
    while (begin < count && depth_m[begin] <= 0.0f) ++begin;
    std::size_t end = begin;
    while (end < count && depth_m[end] > 0.0f) ++end;
    Append(&bytes, static_cast<std::uint16_t>(begin - at));
    Append(&bytes, static_cast<std::uint16_t>(end - begin));
    for (std::size_t i = begin; i < end; ++i)
      Append(&bytes, PackLight({light[3 * i], light[3 * i + 1], light[3 * i + 2]}));
    for (std::size_t i = begin; i < end; ++i) Append(&bytes, PackDepth(depth_m[i]));
    at = end;
  }
  return bytes;
}

bool DecodePixels(const std::string& bytes, const Tile& tile, Canvas* canvas) {
  if (tile.x < 0 || tile.y < 0 || tile.x + tile.width > canvas->width || tile.y + tile.height > canvas->height)
    return false;
  const auto count = static_cast<std::size_t>(tile.num_pixels());
  Bytes left(bytes);
  std::size_t at = 0;
  while (at < count) {
    std::uint16_t run[2];
    if (!left.Take(run, 2) || run[0] + run[1] == 0 || at + run[0] + run[1] > count) return false;
    EachRow(tile, canvas->width, at, at + run[0], [&](std::size_t to, std::size_t, std::size_t pixels) {
      std::fill_n(&canvas->light[to], pixels, 0u);
      std::fill_n(&canvas->depth[to], pixels, std::uint16_t{0});
    });
    at += run[0];
    bool is_whole = true;
    EachRow(tile, canvas->width, at, at + run[1], [&](std::size_t to, std::size_t, std::size_t pixels) {
      is_whole = is_whole && left.Take(&canvas->light[to], pixels);
    });
    EachRow(tile, canvas->width, at, at + run[1], [&](std::size_t to, std::size_t, std::size_t pixels) {
      is_whole = is_whole && left.Take(&canvas->depth[to], pixels);
    });
    if (!is_whole) return false;
    at += run[1];
  }
  return left.is_empty();
}

}  // namespace tiles
