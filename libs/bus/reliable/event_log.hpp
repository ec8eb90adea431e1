#pragma once

#include <cstdint>
#include <vector>

namespace bus::detail {

// The newest kKept events of a writer, encoded and numbered from 1, for retransmission.
class EventLog {
 public:
  static constexpr std::uint64_t kKept = 4096;  // four credits of a reader; 4 s at 1000 events per second

  // `bytes` holds event newest() + 1.
  void Append(std::vector<std::uint8_t> bytes) {
    if (kept_.size() < kKept) {
      kept_.push_back(std::move(bytes));
    } else {
      kept_[static_cast<std::size_t>(newest_ % kKept)] = std::move(bytes);
    }
    ++newest_;
  }
  [[nodiscard]] std::uint64_t newest() const { return newest_; }  // 0: none yet
  [[nodiscard]] std::uint64_t oldest() const { return newest_ - kept_.size() + 1; }
  [[nodiscard]] const std::vector<std::uint8_t>& At(std::uint64_t sequence) const {
    return kept_[static_cast<std::size_t>((sequence - 1) % kKept)];
  }

 private:
  std::vector<std::vector<std::uint8_t>> kept_;
  std::uint64_t newest_ = 0;
};

}  // namespace bus::detail
