#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <vector>

namespace oos {

// Finds which of several devices a person moves to and fro: the first whose way is longer than 0.15 m, while no other
// one's is longer than a third of it.
class Wiggle {
 public:
  explicit Wiggle(std::size_t num_devices) : tracks_(num_devices) {}

  void Add(std::size_t device, const glm::dvec3& p_B) {
    Track& track = tracks_[device];
    // Shorter ways are noise of the sensor.
    constexpr double kStep_m = 0.003;
    if (track.last && glm::distance(*track.last, p_B) < kStep_m) return;
    if (track.last) track.way_m += glm::distance(*track.last, p_B);
    track.last = p_B;
  }
  [[nodiscard]] std::optional<std::size_t> winner() const {
    constexpr double kWay_m = 0.15;
    std::size_t best = 0;
    for (std::size_t i = 1; i < tracks_.size(); ++i) {
      if (tracks_[i].way_m > tracks_[best].way_m) best = i;
    }
    if (tracks_.empty() || tracks_[best].way_m < kWay_m) return std::nullopt;
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      if (i != best && 3.0 * tracks_[i].way_m > tracks_[best].way_m) return std::nullopt;
    }
    return best;
  }

 private:
  struct Track {
    std::optional<glm::dvec3> last;
    double way_m = 0.0;
  };
  std::vector<Track> tracks_;
};

}  // namespace oos
