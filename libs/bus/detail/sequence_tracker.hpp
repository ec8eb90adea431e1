#pragma once

#include <cstdint>

namespace bus::detail {

// Follows the sequence of one writer's life: what is new, late, restored or repeated, and so what is lost. It knows the
// newest message and the 63 before it; what is older and comes after all stays lost.
//
//   newest - first + 1 = received + restored + lost, always
//
// Each of the three is counted for itself, so that a message that is counted twice does not pass for another's loss.
class SequenceTracker {
 public:
  enum class Verdict : std::uint8_t {
    kNew,       // newer than all before
    kLate,      // after a newer one, in time to be counted as received
    kTooLate,   // after so many newer ones that nobody knows whether it came before
    kRepeated,  // came before
  };
  // A complete message came in a datagram of its own.
  Verdict Take(std::uint64_t sequence);
  // Not here yet, and known not to be.
  [[nodiscard]] bool IsMissing(std::uint64_t sequence) const {
    return newest_ != 0 && PlaceOf(sequence) == Place::kMissing;
  }
  // One that is missing came with a later one's datagram.
  void Restore(std::uint64_t sequence);
  void Restart() { *this = SequenceTracker{}; }

  [[nodiscard]] std::uint64_t first() const { return first_; }    // that came by itself; 0: none yet
  [[nodiscard]] std::uint64_t newest() const { return newest_; }  // 0: none yet
  [[nodiscard]] std::uint64_t received() const { return received_; }
  [[nodiscard]] std::uint64_t restored() const { return restored_; }
  [[nodiscard]] std::uint64_t reordered() const { return reordered_; }  // late and too late
  [[nodiscard]] std::uint64_t repeated() const { return repeated_; }
  // What was sent before the first arrival is not lost here: nobody may have been listening.
  [[nodiscard]] std::uint64_t lost() const { return left_behind_ + NumMissing(seen_); }

 private:
  enum class Place : std::uint8_t { kNewer, kMissing, kThere, kUnknown };
  [[nodiscard]] Place PlaceOf(std::uint64_t sequence) const;
  void MarkBehind(std::uint64_t sequence) { seen_ |= std::uint64_t{1} << (newest_ - sequence); }
  void GoOnTo(std::uint64_t sequence);
  // Of the newest and the 63 before it, less what is from before the first, those whose bit is not set.
  [[nodiscard]] std::uint64_t NumMissing(std::uint64_t seen) const;

  std::uint64_t first_ = 0;
  std::uint64_t newest_ = 0;
  std::uint64_t seen_ = 0;         // bit i: newest - i has come
  std::uint64_t left_behind_ = 0;  // not here when they were too far behind to be known
  std::uint64_t received_ = 0;
  std::uint64_t restored_ = 0;
  std::uint64_t reordered_ = 0;
  std::uint64_t repeated_ = 0;
};

}  // namespace bus::detail
