#pragma once

#include <algorithm>
#include <cstdint>

#include "core/wrench.hpp"

namespace device_bridge {

// Impulse since the start of the coupling's part of what was written to a hand device, about W's origin: what the
// objects that the hand touches have to get with the opposite sign. Real-time safe.
class RenderedImpulse {
 public:
  // `written` acts from now_ns on at p_WDo; it is what has become of `wanted`, in which `rest` is not the coupling's.
  void Add(std::int64_t now_ns, const core::Wrench& written, const core::Wrench& wanted, const core::Wrench& rest,
           const glm::dvec3& p_WDo) noexcept {
    J_Wo_W_ += 1e-9 * static_cast<double>(now_ns - since_ns_) * F_Wo_W_;
    since_ns_ = now_ns;
    const double wanted_N = glm::length(wanted.force_N);
    const double share = wanted_N > 0.0 ? std::min(glm::length(written.force_N) / wanted_N, 1.0) : 1.0;
    F_Wo_W_ = core::ShiftWrench(written + -(share * rest), p_WDo);
  }
  [[nodiscard]] const core::Wrench& J_Wo_W() const { return J_Wo_W_; }

 private:
  std::int64_t since_ns_ = 0;
  core::Wrench F_Wo_W_;
  core::Wrench J_Wo_W_;
};

}  // namespace device_bridge
