#pragma once

#include <algorithm>
#include <glm/glm.hpp>

namespace haptic_node {

// Momentum that the objects of physics owe to a hand: impulse that the device has rendered of their contacts, less what
// they have got. haptic_node sends a contact's force as it was when the device was sampled; what the device renders by
// the local contact field, and what physics makes of it at its own poses, with its own damping and friction, are a
// little different. So the forces that go to the objects are scaled until the debt is paid; what is left when the
// contact is over is sent as a force in its place.
class ContactBooks {
 public:
  // Both since the start, on the hand; `share`: of the rendered part, how much is the objects'.
  void Update(const glm::dvec3& rendered_Ns, const glm::dvec3& given_Ns, double share) noexcept {
    const glm::dvec3 change_Ns = share * (rendered_Ns - rendered_Ns_) - (given_Ns - given_Ns_);
    rendered_Ns_ = rendered_Ns;
    given_Ns_ = given_Ns;
    // A sum that begins anew, after a restart, is no debt.
    if (glm::length(change_Ns) < kMostChange_Ns) debt_Ns_ += change_Ns;
    const double length_Ns = glm::length(debt_Ns_);
    if (length_Ns > kMostDebt_Ns) debt_Ns_ *= kMostDebt_Ns / length_Ns;
  }
  // Of the contact forces on the objects; `force_N` is their sum on the hand.
  [[nodiscard]] double Factor(const glm::dvec3& force_N) const noexcept {
    const double square_N2 = glm::dot(force_N, force_N);
    if (!(square_N2 > kLeastForce_N * kLeastForce_N)) return 1.0;
    return std::clamp(1.0 + glm::dot(debt_Ns_, force_N) / (kTime_s * square_N2), 0.0, 4.0);
  }
  // On the hand, in place of a contact that is over.
  [[nodiscard]] glm::dvec3 Owed_N() const noexcept {
    const double length_Ns = glm::length(debt_Ns_);
    if (length_Ns < kLeastDebt_Ns) return glm::dvec3(0.0);
    return std::min(1.0 / kTime_s, kMostOwed_N / length_Ns) * debt_Ns_;
  }

 private:
  // Slow beside the some ticks that the books are late, fast beside a push.
  static constexpr double kTime_s = 0.01;
  static constexpr double kLeastForce_N = 0.1;   // a smaller one is too little to scale: the debt is paid in its place
  static constexpr double kMostChange_Ns = 1.0;  // in a cycle: 50 N over 20 of them
  // Free choices of how wrong the books may get: 50 N, the filter's largest force, for 10 ms, paid at 5 N, which is
  // seen as a push and throws nothing. Larger pay back more of what was lost, and later.
  static constexpr double kMostDebt_Ns = 0.5;
  static constexpr double kMostOwed_N = 5.0;
  static constexpr double kLeastDebt_Ns = 1e-6;  // of a part of 1 g: 1 mm/s
  glm::dvec3 rendered_Ns_{0.0};
  glm::dvec3 given_Ns_{0.0};
  glm::dvec3 debt_Ns_{0.0};
};

}  // namespace haptic_node
