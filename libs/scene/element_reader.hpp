#pragma once

#include <glm/gtc/constants.hpp>
#include <string>
#include <vector>

#include "core/pose.hpp"
#include "scene/schema.hpp"
#include "scene/xml.hpp"

namespace scene {

constexpr double kRadPerDeg = glm::pi<double>() / 180.0;

// Typed access to one element's attributes. An absent or malformed value leaves the target unchanged; the check against
// the rules of schema.hpp has reported it already. Angles are converted from degrees to radians.
class ElementReader {
 public:
  explicit ElementReader(const XmlElement& element) : element_(element) {}

  void Number(const char* name, double* value) const { ParseNumber(element_.Get(name), value); }
  void Degrees(const char* name, double* value_rad) const {
    double value_deg = 0.0;
    if (ParseNumber(element_.Get(name), &value_deg)) *value_rad = value_deg * kRadPerDeg;
  }
  void Boolean(const char* name, bool* value) const { ParseBoolean(element_.Get(name), value); }
  [[nodiscard]] std::uint64_t Count(const char* name, std::uint64_t fallback) const {
    std::uint64_t value = fallback;
    ParseCount(element_.Get(name), &value);
    return value;
  }
  template <typename Vec>
  void Vector(const char* name, Vec* value) const {
    std::vector<double> numbers;
    if (ParseNumbers(element_.Get(name), &numbers) && numbers.size() == 3)
      *value = Vec(numbers[0], numbers[1], numbers[2]);
  }
  [[nodiscard]] core::Pose Pose() const {
    glm::dvec3 position_m(0.0);
    glm::dvec3 rpy_deg(0.0);
    Vector("position", &position_m);
    Vector("rpy_deg", &rpy_deg);
    return {core::QuaternionFromRollPitchYaw(rpy_deg * kRadPerDeg), position_m};
  }

 private:
  const XmlElement& element_;
};

}  // namespace scene
