#pragma once

#include <cstdint>

namespace device_bridge {

// Notices when a tracked head is lost, and when it is there again.
class HeadWatch {
 public:
  enum class News : std::uint8_t { kNone, kFound, kLost };
  // Longer than a head is hidden by a hand that passes.
  static constexpr std::int64_t kLost_ns = 500'000'000;

  // At now_ns a new pose was there, or none. A head that was never there is lost, too.
  News Note(std::int64_t now_ns, bool has_pose) {
    if (last_ns_ == 0 || has_pose) last_ns_ = now_ns;
    const bool is_there = has_pose || (is_there_ && now_ns - last_ns_ <= kLost_ns);
    const bool is_lost = !is_there && now_ns - last_ns_ > kLost_ns;
    News news = News::kNone;
    if (is_there && !is_there_) news = News::kFound;
    if (is_lost && !is_told_lost_) news = News::kLost;
    is_there_ = is_there;
    is_told_lost_ = is_lost;
    return news;
  }

 private:
  std::int64_t last_ns_ = 0;  // of a pose, or of the first look
  bool is_there_ = false;
  bool is_told_lost_ = false;
};

}  // namespace device_bridge
