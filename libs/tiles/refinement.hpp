#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "tiles/pixels.hpp"

namespace tiles {

// A picture that becomes better while nothing moves: the mean of its samples (tiles/quality.hpp).
class Refinement {
 public:
  static constexpr std::uint32_t kFirstShown = 8;  // fewer are noisier than a picture of one sample with hard shadows
  static constexpr std::uint32_t kMost = 64;

  // Which sample the next frame is; none: the picture is as good as it becomes. `digest`: of what it shows.
  std::optional<std::uint32_t> Next(std::uint64_t digest);

  // A sample has been drawn; they come in their order. True when the canvas is a picture to be shown, in place of the
  // sample.
  bool Take(std::uint64_t digest, std::uint32_t sample, Canvas* canvas);

 private:
  std::uint64_t asked_ = 0;  // digest
  std::uint32_t next_ = 0;
  std::uint64_t taken_ = 0;  // digest of the sums
  std::uint32_t num_taken_ = 0;
  std::vector<glm::vec3> sums_;
  std::vector<std::uint16_t> counts_;
  std::vector<std::uint16_t> depth_;  // through the pixels' centres
};

}  // namespace tiles
