#include "physics/testing/trials/peg.hpp"

#include <cmath>

#include "physics/testing/closed_form/contact_laws.hpp"
#include "physics/testing/trials/build.hpp"

namespace physics::trials {
namespace {

constexpr double kHalfBreadth_m = 0.01;  // along y, so that the peg cannot turn out of the plane
constexpr double kLength_m = 0.08;

// Tilt a at which the tip's corner -r touches the wall at depth l and the side +r the mouth's edge. That side's line
// passes the mouth's height (2 r + l sin a) / cos a beside that corner, so this is 2 (r + c); solved by Newton's
// method.
double TiltOfTwoPointContact(const PegParams& p) {
  const double r = p.half_width_m;
  double a = 2.0 * p.clearance_m / p.depth_m;
  for (int i = 0; i < 20; ++i) {
    const double error_m = (2.0 * r + p.depth_m * std::sin(a)) / std::cos(a) - 2.0 * (r + p.clearance_m);
    a -= error_m * std::cos(a) * std::cos(a) / (p.depth_m + 2.0 * r * std::sin(a));
  }
  return a;
}

}  // namespace

bool PegSlidesIn(const PegParams& p, double moment_Nm) {
  const double r = p.half_width_m;
  const double wall = r + p.clearance_m;
  // Hole along -z, its mouth at z = 0. Turning about +y brings the upper end of the peg to +x.
  const double tilt = TiltOfTwoPointContact(p);
  const glm::dquat R = core::QuaternionFromRotationVector({0, tilt, 0});
  const glm::dvec3 corner_S(-r, 0, 0);
  const glm::dvec3 corner_W(-wall, 0, -p.depth_m);
  World world;
  MassProperties mass = BoxMass(0.1, {2 * r, 2 * kHalfBreadth_m, kLength_m});
  mass.p_OCm_m = {0, 0, 0.5 * kLength_m};
  const int peg = AddDynamic(&world, {R, corner_W - R * corner_S}, mass);
  const int tip = world.AddContactPair(peg, world.world_body(), p.kind).value();
  const int mouth = world.AddContactPair(world.world_body(), peg, p.kind).value();
  core::ContactSet at_tip, at_mouth;
  at_tip.friction = at_mouth.friction = static_cast<float>(p.friction);
  at_tip.damping_N_s_per_m = at_mouth.damping_N_s_per_m = 50.0f;  // of the compliant kind, so that it comes to rest
  std::uint32_t id = 0;
  for (const double y : {-kHalfBreadth_m, kHalfBreadth_m}) {
    ++id;
    AddPlane(&at_tip, id, {-r, y, 0}, {-wall, y, 0}, {1, 0, 0}, 0.5 * p.stiffness_N_per_m);
    AddPlane(&at_tip, id + 10, {r, y, 0}, {wall, y, 0}, {-1, 0, 0}, 0.5 * p.stiffness_N_per_m);
    // The mouth's edges on the peg's sides: here the normal points from the peg to the hole.
    AddPlane(&at_mouth, id, {wall, y, 0}, {r, y, 0}, {1, 0, 0}, 0.5 * p.stiffness_N_per_m);
    AddPlane(&at_mouth, id + 10, {-wall, y, 0}, {-r, y, 0}, {-1, 0, 0}, 0.5 * p.stiffness_N_per_m);
  }
  world.SetContactPlanes(tip, at_tip);
  world.SetContactPlanes(mouth, at_mouth);
  world.SetLoad(peg, {{p.F_x_N, 0, -p.F_z_N}, {0, moment_Nm, 0}});
  const auto depth_m = [&] { return -(world.X_WO(peg) * corner_S).z; };
  // Compliant contact first deflects under the load; motion after that is sliding.
  for (int i = 0; i < (p.kind == ContactKind::kHard ? 10 : 200); ++i) world.Step(kDt);
  const double settled_m = depth_m();
  for (int i = 0; i < 50; ++i) world.Step(kDt);
  return depth_m() - settled_m > 1e-5;
}

double FindJammingMoment_Nm(const PegParams& params) {
  const double expected_Nm =
      closed_form::JammingMoment_Nm(params.depth_m, params.half_width_m, params.friction, params.F_x_N, params.F_z_N);
  double slides_Nm = 0.0;
  double jams_Nm = 2.0 * expected_Nm;
  for (int i = 0; i < 11; ++i) {
    const double middle_Nm = 0.5 * (slides_Nm + jams_Nm);
    (PegSlidesIn(params, middle_Nm) ? slides_Nm : jams_Nm) = middle_Nm;
  }
  return 0.5 * (slides_Nm + jams_Nm);
}

}  // namespace physics::trials
