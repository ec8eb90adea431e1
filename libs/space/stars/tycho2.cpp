#include "space/stars/tycho2.hpp"

#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <unordered_map>

namespace space {
namespace {

constexpr std::size_t kBlock = 2880;  // FITS
constexpr std::size_t kCard = 80;
constexpr double kUsualColor = 0.7;              // B - V; median of the bright list between V 7.5 and 9: 0.74
constexpr double kVtMinusVPerColor = 0.106;      // V = VT - 0.090 (BT - VT), B - V = 0.85 (BT - VT) [ESA 1997]
constexpr double kSameStar = 30.0 * 4.84814e-6;  // [rad]
constexpr double kSameMagnitude = 1.5;
constexpr double kTooBright = 2.0;  // for Tycho-2, which has Spica 0.45 arc seconds off

// One table of a FITS file.
struct Table {
  std::span<const std::uint8_t> rows;
  std::size_t row_bytes = 0;
  std::size_t num_rows = 0;
};

// Reads the header at `*at` and moves it to the data behind. False at a damaged header.
bool ReadHeader(std::span<const std::uint8_t> fits, std::size_t* at,
                std::unordered_map<std::string, std::string>* cards) {
  for (; *at + kBlock <= fits.size();) {
    const std::size_t block = *at;
    *at += kBlock;
    for (std::size_t card = block; card < block + kBlock; card += kCard) {
      const std::string_view text(reinterpret_cast<const char*>(&fits[card]), kCard);
      const std::string name(text.substr(0, text.find_first_of(" =")));
      if (name == "END") return true;
      if (text[8] != '=') continue;
      std::string value(text.substr(10, text.find('/', 10) - 10));
      std::erase_if(value, [](char c) { return c == ' ' || c == '\''; });
      (*cards)[name] = value;
    }
  }
  return false;
}

std::size_t Number(const std::unordered_map<std::string, std::string>& cards, const char* name) {
  const auto found = cards.find(name);
  return found == cards.end() ? 0 : std::strtoull(found->second.c_str(), nullptr, 10);
}

// The table whose first column has that name.
core::Result<Table> FindTable(std::span<const std::uint8_t> fits, const std::string& column) {
  for (std::size_t at = 0; at < fits.size();) {
    std::unordered_map<std::string, std::string> cards;
    if (!ReadHeader(fits, &at, &cards)) break;
    const Table table{{}, Number(cards, "NAXIS1"), Number(cards, "NAXIS2")};
    const std::size_t num_bytes = Number(cards, "NAXIS") == 2 ? table.row_bytes * table.num_rows : 0;
    if (num_bytes > fits.size() - at) break;
    if (cards["TTYPE1"] == column) return Table{fits.subspan(at, num_bytes), table.row_bytes, table.num_rows};
    at += (num_bytes + kBlock - 1) / kBlock * kBlock;
  }
  return core::Fail(core::ErrorCode::kDamaged, "no index of Tycho-2: the table " + column + " is missing");
}

template <typename T>
T Read(const std::uint8_t* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

float ReadBigEndianFloat(const std::uint8_t* from) {
  return std::bit_cast<float>(__builtin_bswap32(Read<std::uint32_t>(from)));
}

// Stars by cells of a grid about as large as the distance that is searched.
class Neighbours {
 public:
  explicit Neighbours(std::span<const Star> stars) : stars_(stars) {
    cells_.reserve(stars.size());
    for (std::size_t i = 0; i < stars.size(); ++i) cells_.emplace(Key(CellOf(stars[i].direction_C)), i);
  }

  // Index of the nearest star within the limits; stars_.size(): none.
  [[nodiscard]] std::size_t Find(const Star& star) const {
    std::size_t best = stars_.size();
    double best_distance = kSameStar;
    const glm::i64vec3 middle = CellOf(star.direction_C);
    for (int k = 0; k < 27; ++k) {
      const auto [first, last] = cells_.equal_range(Key(middle + glm::i64vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)));
      for (auto it = first; it != last; ++it) {
        const Star& other = stars_[it->second];
        const double distance = glm::distance(star.direction_C, other.direction_C);
        if (distance >= best_distance || std::abs(star.magnitude - other.magnitude) > kSameMagnitude) continue;
        best = it->second;
        best_distance = distance;
      }
    }
    return best;
  }

 private:
  static glm::i64vec3 CellOf(const glm::dvec3& direction) { return glm::i64vec3(glm::floor(direction / kSameStar)); }
  static std::int64_t Key(const glm::i64vec3& cell) { return (cell.x << 40) ^ (cell.y << 20) ^ cell.z; }

  std::span<const Star> stars_;
  std::unordered_multimap<std::int64_t, std::size_t> cells_;
};

}  // namespace

core::Result<std::vector<Star>> ReadTycho2(std::span<const std::uint8_t> fits) {
  const auto range = FindTable(fits, "kdtree_range_stars");  // lowest x, y, z, highest x, y, z, steps per unit
  const auto data = FindTable(fits, "kdtree_data_stars");    // x, y, z in steps: u32, little-endian
  const auto magnitudes = FindTable(fits, "MAG_VT");         // float, big-endian
  for (const auto* table : {&range, &data, &magnitudes}) {
    if (!*table) return tl::unexpected(table->error());
  }
  if (range->rows.size() != 7 * sizeof(double) || data->row_bytes != 12 || magnitudes->row_bytes != 4 ||
      data->num_rows != magnitudes->num_rows) {
    return core::Fail(core::ErrorCode::kDamaged, "no index of Tycho-2: its tables do not fit each other");
  }
  const auto low = Read<glm::dvec3>(range->rows.data());
  const auto steps_per_unit = Read<double>(range->rows.data() + 6 * sizeof(double));
  std::vector<Star> stars;
  stars.reserve(data->num_rows);
  for (std::size_t i = 0; i < data->num_rows; ++i) {
    const glm::dvec3 steps(Read<glm::uvec3>(data->rows.data() + 12 * i));
    const double vt = ReadBigEndianFloat(magnitudes->rows.data() + 4 * i);
    stars.push_back({glm::normalize(low + steps / steps_per_unit), vt - kVtMinusVPerColor * kUsualColor, kUsualColor});
  }
  return stars;
}

MergedStars MergeStars(std::vector<Star> tycho2, std::span<const Star> bright) {
  const Neighbours neighbours(tycho2);
  std::vector<Star> added;
  std::vector<bool> is_taken(tycho2.size(), false);
  MergedStars merged;
  std::vector<Star> changed = tycho2;  // the search needs Tycho-2's own magnitudes
  for (const Star& star : bright) {
    const std::size_t same = neighbours.Find(star);
    if (same == tycho2.size() || is_taken[same]) {
      added.push_back(star);
      continue;
    }
    is_taken[same] = true;
    changed[same].magnitude = star.magnitude;
    changed[same].color_bv = star.color_bv;
    if (star.magnitude < kTooBright) changed[same].direction_C = star.direction_C;
    ++merged.num_same;
  }
  merged.stars = std::move(changed);
  merged.stars.insert(merged.stars.end(), added.begin(), added.end());
  return merged;
}

}  // namespace space
