#pragma once

#include <array>

#include "core/pose.hpp"
#include "core/wrench.hpp"
#include "hug/arm_model.hpp"
#include "physics/chain/spatial.hpp"

namespace hug {

inline constexpr double kGravity_m_per_s2 = 9.81;  // along -z of the base

// What the joint loop knows of its arm: kinematics and inverse dynamics, at the posture of the latest Place. A
// recursive Newton-Euler of its own rather than a physics engine's: it is forty lines, allocates nothing, and the
// simulated arm itself moves by the articulated-body algorithm (physics::Chain), so that each checks the other.
class ArmDynamics {
 public:
  explicit ArmDynamics(const ArmModel& model) : model_(model) {}

  void Place(const core::Pose& X_WB, const Joints& q, const Joints& speed);

  [[nodiscard]] const core::Pose& X_WL(std::size_t i) const { return X_WL_[i]; }
  [[nodiscard]] const core::Pose& X_WD() const { return X_WD_; }
  [[nodiscard]] core::Twist V_WD() const;
  // Of joint k: the hand's twist at unit speed of the joint, about Do in W.
  [[nodiscard]] core::Twist Column(std::size_t k) const;
  // J^T F: joint torques that put this wrench on the hand.
  [[nodiscard]] Joints TorquesOf(const core::Wrench& F_Do_W) const;
  // The same for a force on a point that moves with link i.
  [[nodiscard]] Joints TorquesOf(std::size_t link, const glm::dvec3& p_WQ, const glm::dvec3& force_W) const;

  // Torques of the motors for these accelerations, at the posture and the speeds of Place, without friction.
  [[nodiscard]] Joints InverseDynamics(const Joints& acceleration, double gravity_m_per_s2 = kGravity_m_per_s2);
  // M(q) a.
  [[nodiscard]] Joints InertiaTimes(const Joints& acceleration);
  // Acceleration of the hand at Do when no joint accelerates: d/dt(J) q'.
  [[nodiscard]] core::Twist BiasAcceleration() const;

  // Joint accelerations (or speeds) of least norm that give the hand this twist; near a singular posture damped.
  [[nodiscard]] Joints PseudoInverseTimes(const core::Twist& twist) const;
  // The wrench on the hand that these joint torques come nearest to: (J^+)^T tau.
  [[nodiscard]] core::Wrench WrenchOf(const Joints& torques) const;
  // What is left of these joint speeds or accelerations when the hand stands still: (E - J^+ J) v.
  [[nodiscard]] Joints NullSpaceOf(const Joints& v) const;

  // Inverse of the apparent inertia of the hand, J M^-1 J^T, angular before linear. Slow; for tests and for limits.
  [[nodiscard]] std::array<std::array<double, 6>, 6> InverseApparentInertia();

  [[nodiscard]] const ArmModel& model() const { return model_; }

 private:
  // (J J^T + d^2 E)^-1 y, and J^T y, with angles times the lever of the .cpp.
  [[nodiscard]] std::array<double, 6> SolveHand(std::array<double, 6> y) const;
  [[nodiscard]] std::array<double, 6> ScaledColumn(std::size_t k) const;

  ArmModel model_;
  std::array<core::Pose, kJoints> X_WL_;
  core::Pose X_WD_;
  std::array<physics::Motion, kJoints> S_;     // joint axes, about the base's origin in W
  std::array<physics::Motion, kJoints> v_;     // of the links
  std::array<physics::Motion, kJoints> bias_;  // velocity product v x S q'
  std::array<physics::SpatialInertia, kJoints> I_;
  glm::dvec3 origin_W_{0.0};
  glm::dvec3 up_W_{0.0, 0.0, 1.0};
};

}  // namespace hug
