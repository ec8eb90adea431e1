#include "bus/latest/sequence_tracker.hpp"

#include <bit>

namespace bus::detail {

SequenceTracker::Place SequenceTracker::PlaceOf(std::uint64_t sequence) const {
  if (sequence > newest_) return Place::kNewer;
  if (sequence < first_) return Place::kThere;  // before this reader's first arrival
  const std::uint64_t behind = newest_ - sequence;
  if (behind >= 64) return Place::kUnknown;
  return (seen_ >> behind & 1) != 0 ? Place::kThere : Place::kMissing;
}

SequenceTracker::Verdict SequenceTracker::Take(std::uint64_t sequence) {
  switch (PlaceOf(sequence)) {
    case Place::kNewer:
      GoOnTo(sequence);
      ++received_;
      return Verdict::kNew;
    case Place::kMissing:
      MarkBehind(sequence);
      ++received_;
      ++reordered_;
      return Verdict::kLate;
    case Place::kUnknown:
      ++reordered_;
      return Verdict::kTooLate;
    case Place::kThere:
      break;
  }
  ++repeated_;
  return Verdict::kRepeated;
}

void SequenceTracker::GoOnTo(std::uint64_t sequence) {
  if (newest_ == 0) {
    first_ = sequence;
    newest_ = sequence;
    seen_ = 1;
    return;
  }
  const std::uint64_t step = sequence - newest_;
  // Bits 64 - step .. 63 leave the window, and so do all sequences skipped beyond it.
  const std::uint64_t staying = step < 64 ? ~std::uint64_t{0} >> step : 0;
  left_behind_ += NumMissing(seen_ | staying) + (step > 64 ? step - 64 : 0);
  seen_ = (step < 64 ? seen_ << step : 0) | 1;
  newest_ = sequence;
}

std::uint64_t SequenceTracker::NumMissing(std::uint64_t seen) const {
  if (newest_ == 0) return 0;
  const std::uint64_t width = newest_ - first_ + 1;
  const std::uint64_t known = width < 64 ? (std::uint64_t{1} << width) - 1 : ~std::uint64_t{0};
  return static_cast<std::uint64_t>(std::popcount(known & ~seen));
}

void SequenceTracker::Restore(std::uint64_t sequence) {
  MarkBehind(sequence);
  ++restored_;
}

}  // namespace bus::detail
