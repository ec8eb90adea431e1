#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>

#include "physics/checkpoint.hpp"

namespace physics {

enum class ImpulseSource : std::uint8_t { kOuter, kContact, kJoint };
constexpr std::size_t kNumImpulseSources = 3;

struct ImpulseMagnitude {
  double Ns = 0.0;
  double Nms = 0.0;
};

// Compares one body's impulses of a step with its change of momentum, both about the world origin. The residual is
// attributed to contacts if one acted in that step, else to joints if one did, else to external forces.
class ImpulseAccount {
 public:
  void Add(ImpulseSource source, const glm::dvec3& impulse_Ns, const glm::dvec3& angular_Nms) {
    impulse_Ns_ += impulse_Ns;
    angular_Nms_ += angular_Nms;
    if (source == ImpulseSource::kContact || source_ == ImpulseSource::kOuter) source_ = source;
  }
  void Close(const glm::dvec3& change_Ns, const glm::dvec3& change_Nms) {
    residuals_[static_cast<std::size_t>(source_)].Ns += change_Ns - impulse_Ns_;
    residuals_[static_cast<std::size_t>(source_)].Nms += change_Nms - angular_Nms_;
    impulse_Ns_ = angular_Nms_ = glm::dvec3(0.0);
    source_ = ImpulseSource::kOuter;
  }
  [[nodiscard]] const glm::dvec3& residual_Ns(ImpulseSource source) const {
    return residuals_[static_cast<std::size_t>(source)].Ns;
  }
  [[nodiscard]] const glm::dvec3& residual_Nms(ImpulseSource source) const {
    return residuals_[static_cast<std::size_t>(source)].Nms;
  }
  void ExchangeState(Checkpoint* checkpoint) { checkpoint->Exchange(&residuals_); }

 private:
  struct Residual {
    glm::dvec3 Ns{0.0};
    glm::dvec3 Nms{0.0};
  };
  ImpulseSource source_ = ImpulseSource::kOuter;
  glm::dvec3 impulse_Ns_{0.0};
  glm::dvec3 angular_Nms_{0.0};
  std::array<Residual, kNumImpulseSources> residuals_{};
};

}  // namespace physics
