#include "hug/arm_model.hpp"

#include <algorithm>
#include <glm/gtc/constants.hpp>
#include <utility>

namespace hug {
namespace {

constexpr double kDeg = glm::pi<double>() / 180.0;

// Classical Denavit-Hartenberg table of the LWR4+: all a are zero, d = 0.310, 0.400, 0.390 and 0.078 m at joints 1, 3,
// 5 and 7, alpha as below. Limits, speeds and torques: data sheet of the LWR4+. The masses add up to 14.5 kg, that of
// the LWR I; their distribution is assumed, and so are the rotors' inertias.
struct JointFigures {
  double d_m;
  double alpha_deg;
  double limit_deg;
  double speed_deg_per_s;
  double torque_Nm;
  double mass_kg;      // of the link that the joint moves
  double length_m;     // of that link's tube
  double rotor_kg_m2;  // at the output
  double ready_deg;
};
constexpr JointFigures kFigures[kJoints] = {
    {0.310, 90.0, 170.0, 110.0, 176.0, 2.7, 0.20, 1.00, 0.0},
    {0.0, -90.0, 120.0, 110.0, 176.0, 2.7, 0.20, 1.00, -40.0},
    {0.400, -90.0, 170.0, 128.0, 100.0, 2.7, 0.20, 0.50, 0.0},
    {0.0, 90.0, 120.0, 128.0, 100.0, 2.7, 0.20, 0.50, 80.0},
    {0.390, 90.0, 170.0, 204.0, 100.0, 1.7, 0.19, 0.17, 0.0},
    {0.0, -90.0, 120.0, 184.0, 38.0, 1.6, 0.08, 0.17, -60.0},
    {kFlange_m, 0.0, 170.0, 184.0, 38.0, 0.4, 0.06, 0.10, 0.0},
};

core::Pose AboutZ(double angle) {
  return {core::QuaternionFromRotationVector({0.0, 0.0, angle}), glm::dvec3(0.0)};
}

// Link i's frame is at its joint, z along the axis. In Denavit-Hartenberg's the transform behind joint i is
// Rot_z(q) Trans_z(d) Rot_x(alpha), so joint i + 1 is at Trans_z(d_i) Rot_x(alpha_i) of link i.
core::Pose X_PJ(std::size_t joint) {
  if (joint == 0) return {};
  const JointFigures& before = kFigures[joint - 1];
  return {core::QuaternionFromRollPitchYaw({before.alpha_deg * kDeg, 0.0, 0.0}), {0.0, 0.0, before.d_m}};
}

}  // namespace

ArmModel LightWeightRobot(const HandMount& mount) {
  ArmModel model;
  model.mount = mount;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const JointFigures& f = kFigures[i];
    physics::ChainLink link;
    link.parent = static_cast<int>(i) - 1;
    link.X_PJ = X_PJ(i);
    // Where the arm goes on in the link's frame: along z when d is, else along the next joint's z.
    const glm::dvec3 along = f.d_m > 0.0 ? glm::dvec3(0, 0, 1) : X_PJ(std::min(i + 1, kJoints - 1)).rotate({0, 0, 1});
    const glm::dvec3 size = glm::dvec3(0.09) + (f.length_m - 0.09) * glm::abs(along);
    link.mass = physics::BoxMass(f.mass_kg, size);
    link.mass.p_OCm_m = 0.5 * f.length_m * along;
    link.rotor_kg_m2 = f.rotor_kg_m2;
    link.damping = 0.3 * f.rotor_kg_m2;
    // The joint's own end stop, two degrees beyond the limit that the springs keep.
    link.lower = -(f.limit_deg + 2.0) * kDeg;
    link.upper = (f.limit_deg + 2.0) * kDeg;
    model.limit[i] = f.limit_deg * kDeg;
    model.max_speed[i] = f.speed_deg_per_s * kDeg;
    model.max_torque[i] = f.torque_Nm;
    model.ready[i] = f.ready_deg * kDeg;
    model.links.push_back(link);
  }
  physics::MassProperties& last = model.links.back().mass;
  const glm::dvec3 p = glm::dvec3(0.0, 0.0, kFlange_m) + mount.X_FD.translation;
  const double sum_kg = last.mass_kg + mount.mass_kg;
  const glm::dvec3 middle = (last.mass_kg * last.p_OCm_m + mount.mass_kg * p) / sum_kg;
  const auto shifted = [&](double mass_kg, const glm::dvec3& at) {  // Steiner
    const glm::dvec3 r = at - middle;
    return mass_kg * (glm::dmat3(glm::dot(r, r)) - glm::outerProduct(r, r));
  };
  last.I_Cm_O_kg_m2 += shifted(last.mass_kg, last.p_OCm_m) + shifted(mount.mass_kg, p);
  last.p_OCm_m = middle;
  last.mass_kg = sum_kg;
  return model;
}

core::Pose DenavitHartenbergX_BF(const Joints& q) {
  core::Pose X;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const core::Pose behind{core::QuaternionFromRollPitchYaw({kFigures[i].alpha_deg * kDeg, 0.0, 0.0}),
                            {0.0, 0.0, kFigures[i].d_m}};
    X = X * AboutZ(q[i]) * behind;
  }
  return X;
}

}  // namespace hug
