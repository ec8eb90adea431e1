#include "bus/detail/sequence_tracker.hpp"

namespace bus::detail {

SequenceTracker::Place SequenceTracker::PlaceOf(std::uint64_t sequence) const {
  if (sequence > newest_) return Place::kNewer;
  if (sequence < first_) return Place::kThere;  // from before this reader's time
  const std::uint64_t behind = newest_ - sequence;
  if (behind >= 64) return Place::kUnknown;
  return (seen_ >> behind & 1) != 0 ? Place::kThere : Place::kMissing;
}

SequenceTracker::Verdict SequenceTracker::Take(std::uint64_t sequence) {
  switch (PlaceOf(sequence)) {
    case Place::kNewer: {
      const std::uint64_t step = sequence - newest_;
      if (newest_ == 0) first_ = sequence;
      seen_ = step < 64 ? seen_ << step : 0;
      seen_ |= 1;
      newest_ = sequence;
      ++received_;
      return Verdict::kNew;
    }
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

void SequenceTracker::Restore(std::uint64_t sequence) {
  MarkBehind(sequence);
  ++restored_;
}

}  // namespace bus::detail
