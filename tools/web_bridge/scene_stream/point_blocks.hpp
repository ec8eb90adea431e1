#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tools/web_bridge/scene_stream/numbers.hpp"

namespace scene_stream {

// Many points that frames have in common are sent once, as a block with a number.
class PointBlocks {
 public:
  static constexpr std::size_t kMostHere = 64;  // points that stay in the frame

  using Send = std::function<void(std::uint32_t number, const std::string& floats)>;
  explicit PointBlocks(Send send) : send_(std::move(send)) {}

  // The number of these points; sends them when they are new. As long as a frame of the last kKept may name them, their
  // place in memory is not taken by others.
  template <class Point>
  std::uint32_t NumberOf(const std::shared_ptr<const std::vector<Point>>& points) {
    const auto [known, is_new] = blocks_.try_emplace(points.get(), Block{points, ++last_, 0});
    Block& block = known->second;
    block.age = 0;
    if (is_new) {
      std::string floats;
      Append(std::span<const Point>(*points), &floats);
      send_(block.number, floats);
    } else {
      --last_;
    }
    return block.number;
  }

  // After each frame: forgets what none of the newest kKept frames has named.
  void Age() {
    for (auto block = blocks_.begin(); block != blocks_.end();) {
      block = ++block->second.age > kKept ? blocks_.erase(block) : std::next(block);
    }
  }

 private:
  static constexpr int kKept = 300;
  struct Block {
    std::shared_ptr<const void> points;
    std::uint32_t number;
    int age;
  };

  Send send_;
  std::map<const void*, Block> blocks_;
  std::uint32_t last_ = 0;
};

}  // namespace scene_stream
