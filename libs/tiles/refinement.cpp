#include "tiles/refinement.hpp"

namespace tiles {

std::optional<std::uint32_t> Refinement::Next(std::uint64_t digest) {
  if (digest != asked_) next_ = 0;
  asked_ = digest;
  if (next_ > kMost) return std::nullopt;
  return next_++;
}

// What is seen at a pixel is what is at its centre; a sample that passes it by says nothing.
bool Refinement::Take(std::uint64_t digest, std::uint32_t sample, Canvas* canvas) {
  if (sample == 0) {
    taken_ = digest;
    num_taken_ = 0;
    sums_.assign(canvas->light.size(), glm::vec3(0.0f));
    counts_.assign(canvas->light.size(), 0);
    depth_ = canvas->depth;
    return true;
  }
  if (digest != taken_ || canvas->light.size() != sums_.size()) return false;
  ++num_taken_;
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    if (canvas->depth[i] == 0) continue;
    sums_[i] += UnpackLight(canvas->light[i]);
    ++counts_[i];
  }
  if (num_taken_ < kFirstShown) return false;
  canvas->depth = depth_;
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    const glm::vec3 mean = counts_[i] == 0 ? glm::vec3(0.0f) : sums_[i] / static_cast<float>(counts_[i]);
    canvas->light[i] = PackLight(mean);
  }
  return true;
}

}  // namespace tiles
