#pragma once

#include <cstdint>

namespace bus::detail {

// Tracks the sequence numbers of one life of a writer: which are new, late, restored or repeated, and hence lost. It
// remembers the newest message and the 63 before it; a message that arrives later than that stays lost.
//
//   newest - first + 1 = received + restored + lost, always
//
// The three are counted independently, so that one message counted twice cannot hide the loss of another.
class SequenceTracker {
 public:
  enum class Verdict : std::uint8_t {
    kNew,       // newer than all before
    kLate,      // older than the newest, within the window: counts as received
    kTooLate,   // older than the window: may be a duplicate
    kRepeated,  // a duplicate
  };
  // A complete message arrived in its own datagram.
  Verdict Take(std::uint64_t sequence);
  // Within the window, and not here.
  [[nodiscard]] bool IsMissing(std::uint64_t sequence) const {
    return newest_ != 0 && PlaceOf(sequence) == Place::kMissing;
  }
  // A missing message arrived as a copy in a later one's datagram.
  void Restore(std::uint64_t sequence);
  void Restart() { *this = SequenceTracker{}; }

  [[nodiscard]] std::uint64_t first() const { return first_; }    // that arrived in its own datagram; 0: none yet
  [[nodiscard]] std::uint64_t newest() const { return newest_; }  // 0: none yet
  [[nodiscard]] std::uint64_t received() const { return received_; }
  [[nodiscard]] std::uint64_t restored() const { return restored_; }
  [[nodiscard]] std::uint64_t reordered() const { return reordered_; }  // late and too late
  [[nodiscard]] std::uint64_t repeated() const { return repeated_; }
  // Messages before the first arrival do not count here: the reader may not have existed.
  [[nodiscard]] std::uint64_t lost() const { return left_behind_ + NumMissing(seen_); }

 private:
  enum class Place : std::uint8_t { kNewer, kMissing, kThere, kUnknown };
  [[nodiscard]] Place PlaceOf(std::uint64_t sequence) const;
  void MarkBehind(std::uint64_t sequence) { seen_ |= std::uint64_t{1} << (newest_ - sequence); }
  void GoOnTo(std::uint64_t sequence);
  // Cleared bits of the window, except those before `first_`.
  [[nodiscard]] std::uint64_t NumMissing(std::uint64_t seen) const;

  std::uint64_t first_ = 0;
  std::uint64_t newest_ = 0;
  std::uint64_t seen_ = 0;         // bit i: newest - i has arrived
  std::uint64_t left_behind_ = 0;  // still missing when they left the window
  std::uint64_t received_ = 0;
  std::uint64_t restored_ = 0;
  std::uint64_t reordered_ = 0;
  std::uint64_t repeated_ = 0;
};

}  // namespace bus::detail
