#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "tactile/usb_table.hpp"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/reader.hpp"

namespace fuzz {
namespace {

// Constant, levels of one byte and of two, checksum: each kind of field.
tactile::UsbTable TableOfEachField() {
  using Kind = tactile::FrameField::Kind;
  tactile::UsbTable table;
  table.num_channels = 3;
  table.frame = {{Kind::kConstant, 1, 0xa5, 0},
                 {Kind::kLevel, 1, 255, 0},
                 {Kind::kLevel, 1, 100, 1},
                 {Kind::kLevel, 2, 1000, 2},
                 {Kind::kXor, 1, 0, 0}};
  return table;
}

}  // namespace

// The bytes as a frame, and as levels.
void FuzzUsbFrame(Input input) {
  static const tactile::UsbTable table = TableOfEachField();
  std::vector<float> levels;
  std::vector<std::uint8_t> bytes;
  if (tactile::DecodeFrame(table, input, &levels)) {
    Claim(levels.size() == table.num_channels, "a level for each channel");
    for (const float level : levels) Claim(level >= 0.0F && level <= 1.0F, "a level is a share");
    tactile::EncodeFrame(table, levels, &bytes);
    Claim(bytes.size() == input.size() && std::equal(bytes.begin(), bytes.end(), input.begin()),
          "what was read is written as it stood");
  }
  std::array<float, 3> wild{};
  std::memcpy(wild.data(), input.data(), std::min(input.size(), sizeof wild));
  tactile::EncodeFrame(table, wild, &bytes);
  Claim(bytes.size() == table.num_bytes(), "a frame is whole");
  Claim(tactile::DecodeFrame(table, bytes, &levels), "what was written is read");
  for (std::size_t i = 0; i < wild.size(); ++i) {
    const bool is_level = wild[i] >= 0.0F && wild[i] <= 1.0F;
    Claim(std::abs(levels[i] - (is_level ? wild[i] : 0.0F)) <= 0.006F, "a level is what was asked for, and else off");
  }
}

}  // namespace fuzz
