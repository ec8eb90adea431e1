#pragma once

#include <optional>

namespace visual_node {

// Adapts the exposure to the luminance of what is shown, as an eye does: towards kGrey / mean luminance, within limits,
// by the time constant. The caller's clock drives it, so that tests and replays can.
class Exposure {
 public:
  // Chosen by eye on the scenarios. kDaylight suits a satellite in the sun, and pictures that are to be compared have
  // it.
  static constexpr float kDaylight = 1.3f;
  static constexpr float kLeast = 0.6f;
  static constexpr float kMost = 5.0f;
  static constexpr float kGrey = 0.22f;
  static constexpr double kTimeConstant_s = 0.6;

  // `mean_luminance`: Film::MeanLuminance; none leaves the exposure as it is.
  void Update(std::optional<float> mean_luminance, double dt_s);

  [[nodiscard]] float value() const { return value_; }

 private:
  float value_ = kDaylight;
};

}  // namespace visual_node
