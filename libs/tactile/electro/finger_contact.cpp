#include "tactile/electro/finger_contact.hpp"

#include <algorithm>

namespace tactile {
namespace {

glm::dvec2 OnPad(const glm::dvec3& p_B) {
  return {p_B.y, p_B.z};
}

}  // namespace

void FingerSense::Begin(std::int64_t now_ns, const core::Pose& X_WB) {
  before_ns_ = now_ns_;
  now_ns_ = now_ns;
  X_BW_ = X_WB.inverse();
  sum_ = {};
}

void FingerSense::Add(std::size_t pair, const core::ContactSet& contacts, const core::Pose& X_WS,
                      const core::Pose& X_WG, bool is_sampled) {
  const core::Pose X_BO = X_BW_ * (is_sampled ? X_WG : X_WS);
  Seen& before = before_[pair];
  const bool has_speed = before.time_ns != 0 && before.time_ns == before_ns_ && now_ns_ > before_ns_;
  const double dt_s = static_cast<double>(now_ns_ - before_ns_) * 1e-9;
  for (const core::ContactPlane& plane : contacts.planes) {
    const glm::dvec3 p_W = X_WS * glm::dvec3(plane.p_S);
    const double gap_m = glm::dot(X_WG.rotate(glm::dvec3(plane.n_G)), p_W - X_WG * glm::dvec3(plane.q_G));
    if (!(gap_m < 0.0)) continue;
    const double press_N = -gap_m * static_cast<double>(plane.stiffness_N_per_m);
    const glm::dvec3 p_B = X_BW_ * p_W;
    sum_.depth_m = std::max(sum_.depth_m, -gap_m);
    sum_.force_N += press_N;
    sum_.place_m += press_N * OnPad(p_B);
    // Where the other body's point that is here now was a step ago.
    if (has_speed) sum_.slip_m_per_s += press_N / dt_s * OnPad(p_B - before.X_BO * (X_BO.inverse() * p_B));
  }
  before = {now_ns_, X_BO};
}

FingerContact FingerSense::End() {
  FingerContact contact = sum_;
  if (!(sum_.force_N > 0.0)) {
    place_before_m_.reset();
    return contact;
  }
  contact.place_m /= sum_.force_N;
  contact.slip_m_per_s /= sum_.force_N;
  const double dt_s = static_cast<double>(now_ns_ - before_ns_) * 1e-9;
  if (place_before_m_ && dt_s > 0.0) contact.travel_m_per_s = (contact.place_m - *place_before_m_) / dt_s;
  place_before_m_ = contact.place_m;
  return contact;
}

}  // namespace tactile
