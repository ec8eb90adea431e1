#include "nodes/device_bridge/arms/jointed_arm.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

namespace device_bridge {
namespace {

constexpr double kApparentShare = 0.3;  // inertia that remains after feed-forward, as published for HUG
constexpr double kMaxStep_s = 2.5e-4;   // the grip's spring is explicit: gains less than 5 % energy (jointed_arm_test)
constexpr double kDeg = glm::pi<double>() / 180.0;

struct ArmLink {
  double along_m;   // distance from the previous joint
  double roll_deg;  // rotation relative to the previous joint's frame, about x
  double mass_kg;
  double length_m;  // of the link's tube, along the arm
  double limit_deg;
  double rotor_kg_m2;  // apparent inertia of the rotor; assumed
  double middle_deg;   // joint angle of the middle posture
};

// Lengths (0.31, 0.40, 0.39 and 0.08 m from joint to joint) and joint limits of a KUKA LWR4+, and the total mass
// of 14.4 kg of its predecessor LWR I, rounded; the axes lie along and across the arm in turn. The distribution of the
// mass over the links is assumed.
constexpr ArmLink kLinks[] = {
    {0.11, 0.0, 2.7, 0.20, 170.0, 0.30, 0.0},   {0.20, 90.0, 2.7, 0.20, 120.0, 0.30, 40.0},
    {0.20, -90.0, 2.7, 0.20, 170.0, 0.15, 0.0}, {0.20, 90.0, 2.7, 0.20, 120.0, 0.15, 80.0},
    {0.20, -90.0, 1.7, 0.19, 170.0, 0.05, 0.0}, {0.19, 90.0, 1.6, 0.08, 120.0, 0.05, -50.0},
    {0.08, -90.0, 0.3, 0.06, 170.0, 0.03, 0.0},
};

physics::Chain MakeChain() {
  std::vector<physics::ChainLink> links;
  bool is_across = false;  // the previous link runs along y of its frame, not z
  for (const ArmLink& figures : kLinks) {
    physics::ChainLink link;
    link.parent = static_cast<int>(links.size()) - 1;
    link.X_PJ.translation = is_across ? glm::dvec3(0, figures.along_m, 0) : glm::dvec3(0, 0, figures.along_m);
    link.X_PJ.rotation = core::QuaternionFromRollPitchYaw({figures.roll_deg * kDeg, 0.0, 0.0});
    is_across = figures.roll_deg > 0.0;
    const glm::dvec3 size =
        is_across ? glm::dvec3(0.09, figures.length_m, 0.09) : glm::dvec3(0.09, 0.09, figures.length_m);
    link.mass = physics::BoxMass(kApparentShare * figures.mass_kg, size);
    link.mass.p_OCm_m = is_across ? glm::dvec3(0, 0.5 * figures.length_m, 0) : glm::dvec3(0, 0, 0.5 * figures.length_m);
    link.rotor_kg_m2 = figures.rotor_kg_m2;
    link.damping = 0.3 * figures.rotor_kg_m2;
    link.lower = -figures.limit_deg * kDeg;
    link.upper = figures.limit_deg * kDeg;
    links.push_back(link);
  }
  return std::move(*physics::Chain::Create(std::move(links)));  // cannot fail: the table above is valid
}

}  // namespace

JointedArm::JointedArm(const core::Pose& X_WD)
    : chain_(MakeChain()), state_(chain_.MakeState()), wrenches_(kLast + 1), motors_(kLast + 1) {
  for (std::size_t i = 0; i <= kLast; ++i) state_.position[i] = kLinks[i].middle_deg * kDeg;
  chain_.Place(state_);
  state_.X_WB = X_WD * chain_.X_WL(kLast).inverse();  // the base is at the origin so far, so X_WL(kLast) is X_BD
  chain_.Place(state_);
}

// Wrench on D, with the target T of the hand, stiffness K, damping B and drag b (all about D, in W):
//   f   = F + K_f (p_T - p_D) + B_f (v_T - v_D) - b_f v_D,
//   tau = T - K_t Log(R_WD R_WT^-1) + B_t (w_T - w_D) - b_t w_D.
void JointedArm::Advance(double dt_s, const core::Wrench& F_Do_W, const Grip& grip) noexcept {
  const int steps = std::max(1, static_cast<int>(std::ceil(dt_s / kMaxStep_s - 1e-9)));
  const double step_s = dt_s / steps;
  core::Pose X_WT = grip.X_WT;
  for (int i = 0; i < steps; ++i) {
    // The target in the middle of the step, its mean pose.
    const core::Pose X_WTm{
        core::QuaternionFromRotationVector(0.5 * step_s * grip.V_WT.angular_rad_per_s) * X_WT.rotation,
        X_WT.translation + 0.5 * step_s * grip.V_WT.linear_m_per_s};
    const core::Twist V_WD_now = V_WD();
    core::Wrench& F = wrenches_[kLast];
    F.force_N = F_Do_W.force_N + grip.stiffness_N_per_m * (X_WTm.translation - X_WD().translation) +
                grip.damping_N_s_per_m * (grip.V_WT.linear_m_per_s - V_WD_now.linear_m_per_s) -
                grip.drag_N_s_per_m * V_WD_now.linear_m_per_s;
    F.torque_Nm = F_Do_W.torque_Nm -
                  grip.stiffness_Nm_per_rad * core::RotationVector(X_WD().rotation * glm::conjugate(X_WTm.rotation)) +
                  grip.damping_Nm_s_per_rad * (grip.V_WT.angular_rad_per_s - V_WD_now.angular_rad_per_s) -
                  grip.drag_Nm_s_per_rad * V_WD_now.angular_rad_per_s;
    chain_.Step(step_s, motors_, wrenches_, &state_);
    chain_.Place(state_);
    X_WT.translation += step_s * grip.V_WT.linear_m_per_s;
    X_WT.rotation =
        glm::normalize(core::QuaternionFromRotationVector(step_s * grip.V_WT.angular_rad_per_s) * X_WT.rotation);
  }
}

}  // namespace device_bridge
