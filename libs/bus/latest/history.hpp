#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "bus/wire/envelope.hpp"
#include "core/fixed_vector.hpp"

namespace bus::detail {

// Copies of earlier samples of a topic behind the newest one's payload: a reader that keeps history restores from them
// samples whose own datagram was lost. One block per sample, newest first, little endian:
//
//    0 u16 payload bytes                         14 u64 direct trace id
//    2 u8  stamps of the direct trace            22 i64 direct trace origin [ns]
//    3 u8  stamps of the other                   30 u64 through-physics trace id
//    4 u16 sequence numbers before the newest    38 i64 through-physics trace origin [ns]
//    6 i64 publish time [ns]                     46 stamps as in the envelope, then the payload

// Repairs two losses in a row; at 10 % loss a third follows once in 1000 messages.
constexpr std::size_t kMaxEarlierSamples = 2;
// Larger samples are not repeated: the newest needs its room in the datagram.
constexpr std::size_t kMaxEarlierBytes = 512;

// Sender's side: keeps the last two samples as they were sent.
class EarlierSamples {
 public:
  // Writes those blocks of the samples just before `sequence` that fit into `room`. Returns their bytes.
  std::size_t Write(std::uint64_t sequence, std::uint8_t* out, std::size_t room) const noexcept;
  // Remembers the sample that was just sent.
  void Keep(const core::Header& header, std::span<const std::uint8_t> payload) noexcept;
  void Forget() { blocks_ = {}; }

 private:
  struct Block {
    std::uint64_t sequence = 0;
    std::size_t size = 0;
    std::array<std::uint8_t, kMaxEarlierBytes> bytes;
  };
  std::array<Block, kMaxEarlierSamples> blocks_;  // by sequence modulo their number
};

struct EarlierSample {
  core::Header header;
  std::span<const std::uint8_t> payload;
};

// Receiver's side: takes the first block off `blocks`. False: none is left, or the bytes are no such block (then
// `blocks` is not empty).
bool NextEarlierSample(std::uint64_t sequence, std::span<const std::uint8_t>* blocks, EarlierSample* sample) noexcept;

}  // namespace bus::detail
