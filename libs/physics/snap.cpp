#include "physics/snap.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace physics {
namespace {

enum SnapRow : std::size_t { kX, kY, kZ, kRotX, kRotY, kRotZ, kNumRows };

// Lever by which the scenario's damping [N s/m] becomes an angular one [N m s/rad].
constexpr double kDampingLever_m = 0.05;
// Once guided, the child is let go only well outside the tolerance at which it was taken: no chatter at the edge.
constexpr double kLeaveFactor = 4.0;
// The guide takes hold over this part of its length, so that an off-centre child is not hit by the full stiffness.
constexpr double kMouth = 0.25;

// A guide shorter than this could not hold the snap's own travel.
double GuideLength_m(const SnapParams& params) {
  return std::max(params.guide_length_m, 2.0 * params.travel_m);
}

}  // namespace

double SnapReleasePoint_m(const SnapParams& params) {
  return std::max(0.0, params.release_force_N) / std::max(1.0, params.stiffness_N_per_m);
}

double SnapEngagePoint_m(const SnapParams& params) {
  return std::min(0.5 * SnapReleasePoint_m(params), 0.25 * params.travel_m);
}

SnapForce SnapAxialForce(const SnapParams& params, bool is_engaged, double z_m) {
  if (is_engaged) return {-params.stiffness_N_per_m * z_m, params.stiffness_N_per_m};
  const double z_e = SnapEngagePoint_m(params);
  if (z_m <= z_e || z_m >= params.travel_m) return {};
  const double width = params.travel_m - z_e;
  const double phase = std::numbers::pi * (params.travel_m - z_m) / width;
  return {params.engage_force_N * std::sin(phase),
          std::max(0.0, params.engage_force_N * std::numbers::pi / width * std::cos(phase))};
}

Snap::Snap(const SnapParams& params) : Mechanism(kNumRows), params_(params), is_guided_(params.is_initially_engaged) {
  state_ = params.is_initially_engaged ? 1 : 0;
}

void Snap::Prepare(const BodyView& parent, const BodyView& child, double /*dt_s*/) {
  const core::Pose X_WJp = parent.X_WO * params_.X_PJ;
  const core::Pose X_WJc = child.X_WO * params_.X_CJ;
  const core::Pose X_PC = X_WJp.inverse() * X_WJc;
  const glm::dvec3 offset = X_PC.translation;  // in J_parent
  const glm::dvec3 turn = core::RotationVector(X_PC.rotation);
  const double z = offset.z;
  const double lateral = std::hypot(offset.x, offset.y);
  const double tilt = glm::length(turn);
  const double guide = GuideLength_m(params_);
  position_ = z;

  if (state_ == 1) {
    is_guided_ = true;
    if (z > SnapReleasePoint_m(params_)) state_ = 0;
  } else if (!is_guided_) {
    is_guided_ = z < guide && z > -params_.travel_m && lateral <= params_.lateral_tolerance_m &&
                 tilt <= params_.tilt_tolerance_rad;
  } else if (z > guide || lateral > kLeaveFactor * params_.lateral_tolerance_m ||
             tilt > kLeaveFactor * params_.tilt_tolerance_rad) {
    is_guided_ = false;
  }
  if (is_guided_ && state_ == 0 && z <= SnapEngagePoint_m(params_)) state_ = 1;

  if (!is_guided_) {
    DeactivateAll();
    return;
  }
  const double hold = state_ == 1 ? 1.0 : std::clamp((guide - z) / (kMouth * guide), 0.0, 1.0);
  const double k = hold * params_.stiffness_N_per_m;
  const double k_t = hold * params_.stiffness_Nm_per_rad;
  const double d = hold * params_.damping_N_s_per_m;
  const double d_t = d * kDampingLever_m * kDampingLever_m;
  const glm::dvec3 p_W = X_WJc.translation;
  const glm::dvec3 axes_W[3] = {X_WJp.rotate({1, 0, 0}), X_WJp.rotate({0, 1, 0}), X_WJp.rotate({0, 0, 1})};
  SetSpring(&rows()[kX], axes_W[0], p_W, offset.x, k, d);
  SetSpring(&rows()[kY], axes_W[1], p_W, offset.y, k, d);
  for (std::size_t i = 0; i < 3; ++i) {
    SetAngularSpring(&rows()[kRotX + i], axes_W[i], turn[static_cast<int>(i)], k_t, d_t);
  }
  Row& axial = rows()[kZ];
  const SnapForce snap = SnapAxialForce(params_, state_ == 1, z);
  // Along the guide the child slides freely; the snap's own damping acts where the snap acts.
  SetSpring(&axial, axes_W[2], p_W, 0.0, 0.0, state_ == 1 || z < params_.travel_m ? params_.damping_N_s_per_m : 0.0);
  axial.force = snap.force_N;
  axial.stiffness = snap.stiffness_N_per_m;
}

void Snap::Finish(double dt_s) {
  force_ = rows()[kZ].impulse / dt_s;
}

void Snap::ExchangeState(Checkpoint* checkpoint) {
  Mechanism::ExchangeState(checkpoint);
  checkpoint->Exchange(&params_);
  checkpoint->Exchange(&is_guided_);
}

}  // namespace physics
