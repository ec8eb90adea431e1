#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace visual_node {

// Tells the first wall of a room when all may show a frame: as soon as every other wall that is there has drawn it. A
// wall that has ended, or hangs, is waited for only for a moment, once.
class Barrier {
 public:
  // Chosen: the first is many times the pause between two messages of a wall, the second is longer than any picture
  // takes on a busy machine.
  static constexpr std::int64_t kSilence_ns = 300'000'000;     // nothing heard for so long: the wall is not there
  static constexpr std::int64_t kPatience_ns = 1'000'000'000;  // not drawn after so long: not waited for until it has

  explicit Barrier(std::size_t num_others) : walls_(num_others) {}

  void Begin(std::uint64_t frame, std::int64_t now_ns) {
    frame_ = frame;
    begin_ns_ = now_ns;
  }
  // A wall has said at heard_ns that it has drawn that frame.
  void Take(std::size_t wall, std::uint64_t frame, std::int64_t heard_ns) {
    walls_[wall].frame = frame;
    walls_[wall].heard_ns = heard_ns;
    walls_[wall].is_known = true;
  }

  [[nodiscard]] bool IsThere(std::size_t wall, std::int64_t now_ns) const {
    return walls_[wall].is_known && now_ns - walls_[wall].heard_ns < kSilence_ns;
  }

  bool IsOpen(std::int64_t now_ns) {
    bool is_open = true;
    for (std::size_t i = 0; i < walls_.size(); ++i) {
      Wall& wall = walls_[i];
      if (wall.frame >= frame_) wall.is_behind = false;
      if (!IsThere(i, now_ns) || wall.frame >= frame_ || wall.is_behind) continue;
      wall.is_behind = now_ns - begin_ns_ >= kPatience_ns;
      is_open = is_open && wall.is_behind;
    }
    return is_open;
  }

  // Walls that are there and draw each frame.
  [[nodiscard]] std::size_t NumInStep(std::int64_t now_ns) const {
    std::size_t number = 0;
    for (std::size_t i = 0; i < walls_.size(); ++i) number += IsThere(i, now_ns) && !walls_[i].is_behind ? 1 : 0;
    return number;
  }

 private:
  struct Wall {
    std::uint64_t frame = 0;
    std::int64_t heard_ns = 0;
    bool is_known = false;
    bool is_behind = false;
  };
  std::vector<Wall> walls_;
  std::uint64_t frame_ = 0;
  std::int64_t begin_ns_ = 0;
};

}  // namespace visual_node
