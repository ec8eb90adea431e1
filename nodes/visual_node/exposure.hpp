#pragma once

#include <optional>

namespace visual_node {

// Adapts the exposure to the luminance of what is shown, as an eye does: towards kGrey / mean luminance, within limits,
// by the time constant. The caller's clock drives it, so that tests and replays can.
class Exposure {
 public:
  // Chosen by eye on the scenarios: 1 suits a satellite in the sun, and pictures that are to be compared have it.
  static constexpr float kLeast = 0.5f;
  static constexpr float kMost = 4.0f;
  static constexpr float kGrey = 0.20f;
  static constexpr double kTimeConstant_s = 0.6;

  // `mean_luminance`: Film::MeanLuminance; none leaves the exposure as it is.
  void Update(std::optional<float> mean_luminance, double dt_s);

  [[nodiscard]] float value() const { return value_; }

 private:
  float value_ = 1.0f;
};

}  // namespace visual_node
