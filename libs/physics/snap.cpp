#include "physics/snap.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace physics {
namespace {

enum SnapRow : std::size_t { kSnapX, kSnapY, kSnapZ, kRotX, kRotY, kRotZ, kNumRows };

// Lever that converts the scenario's damping d [N s/m] into an angular one, d lever^2 [N m s/rad]: the half width of a
// part for a hand. With 0.2 m Insertion.ModuleOnAHandle* jolts, with 0.01 it does not.
constexpr double kDampingLever_m = 0.05;
// For shorter ways in a step the force at z is used, as the quotient work / way would lose its digits.
constexpr double kShortest_m = 1e-9;
// Hysteresis: a guided child is released at this multiple of the tolerances, which avoids chatter at their edge. A free
// choice: 1 and 20 pass every test; a larger one holds what is pulled out askew for longer.
constexpr double kLeaveFactor = 4.0;
// The guide's springs rise to their full stiffness over this part of its length, which avoids a jump of force on an
// off-centre child. A free choice: from 0.02 to 1 every test passes; longer is softer where a part enters.
constexpr double kMouth = 0.25;

// Length of the guide: at least twice the snap's travel, so that it covers that.
double GuideLength_m(const SnapParams& params) {
  return std::max(params.guide_length_m, 2.0 * params.travel_m);
}

}  // namespace

double SnapReleasePoint_m(const SnapParams& params) {
  return std::max(0.0, params.release_force_N) / std::max(1.0, params.stiffness_N_per_m);
}

double SnapEngagePoint_m(const SnapParams& params) {
  const double inner_m = params.profile.num_points > 0 ? params.profile.z_m[0] : 0.25 * params.travel_m;
  return std::min(0.5 * SnapReleasePoint_m(params), inner_m);
}

SnapForce SnapAxialForce(const SnapParams& params, bool is_engaged, double z_m) {
  if (is_engaged) return {-params.stiffness_N_per_m * z_m, params.stiffness_N_per_m};
  if (params.profile.num_points > 0) {
    return {params.engage_force_N * params.profile.Share(z_m),
            std::max(0.0, -params.engage_force_N * params.profile.Slope_per_m(z_m))};
  }
  const double z_e = SnapEngagePoint_m(params);
  if (z_m <= z_e || z_m >= params.travel_m) return {};
  const double width = params.travel_m - z_e;
  const double phase = std::numbers::pi * (params.travel_m - z_m) / width;
  return {params.engage_force_N * std::sin(phase),
          std::max(0.0, params.engage_force_N * std::numbers::pi / width * std::cos(phase))};
}

double SnapAxialEnergy_J(const SnapParams& params, bool is_engaged, double z_m) {
  if (is_engaged) return 0.5 * params.stiffness_N_per_m * z_m * z_m;
  if (params.profile.num_points > 0) return params.engage_force_N * params.profile.Area_m(z_m);
  const double width = params.travel_m - SnapEngagePoint_m(params);
  const double phase = std::numbers::pi * std::clamp((params.travel_m - z_m) / width, 0.0, 1.0);
  return params.engage_force_N * width / std::numbers::pi * (1.0 - std::cos(phase));
}

double SnapWork_J(const SnapParams& params, double a_m, double b_m, bool* is_engaged) {
  const double z_r = SnapReleasePoint_m(params);
  const double z_e = SnapEngagePoint_m(params);
  double at_m = a_m;
  double work_J = 0.0;
  const auto go_to = [&](double z_m) {
    work_J += SnapAxialEnergy_J(params, *is_engaged, at_m) - SnapAxialEnergy_J(params, *is_engaged, z_m);
    at_m = z_m;
  };
  if (*is_engaged && b_m > z_r) {
    go_to(std::max(a_m, z_r));
    *is_engaged = false;
  } else if (!*is_engaged && b_m <= z_e) {
    go_to(std::min(a_m, z_e));
    *is_engaged = true;
  }
  go_to(b_m);
  return work_J;
}

Snap::Snap(const SnapParams& params) : Mechanism(kNumRows), params_(params), is_guided_(params.is_initially_engaged) {
  state_ = params.is_initially_engaged ? 1 : 0;
  AddTunable("engage_force_N", &params_.engage_force_N);
  AddTunable("release_force_N", &params_.release_force_N);
  AddTunable("stiffness_N_per_m", &params_.stiffness_N_per_m);
  AddTunable("stiffness_Nm_per_rad", &params_.stiffness_Nm_per_rad);
  AddTunable("damping", &params_.damping_N_s_per_m);
}

Snap::Place Snap::PlaceOf(const BodyView& parent, const BodyView& child) const {
  Place place;
  place.X_WJp = parent.X_WO * params_.X_PJ;
  place.X_WJc = child.X_WO * params_.X_CJ;
  const core::Pose X_PC = place.X_WJp.inverse() * place.X_WJc;
  place.offset_m = X_PC.translation;
  place.turn_rad = core::RotationVector(X_PC.rotation);
  return place;
}

double Snap::Hold(double z_m) const {
  const double guide = GuideLength_m(params_);
  return state_ == 1 ? 1.0 : std::clamp((guide - z_m) / (kMouth * guide), 0.0, 1.0);
}

// Updates the guide, the state at a = z - dt v / 2, and the ledger with the work of the last step.
void Snap::UpdateState(const Place& place, double a_m, double v_m_per_s) {
  const glm::dvec3& offset = place.offset_m;
  const double z = offset.z;
  const double lateral = std::hypot(offset.x, offset.y);
  const double tilt = glm::length(place.turn_rad);
  const double guide = GuideLength_m(params_);
  bool is_engaged = state_ == 1;
  if (is_engaged) {
    is_guided_ = true;
  } else if (!is_guided_) {
    is_guided_ = z < guide && z > -params_.travel_m && lateral <= params_.lateral_tolerance_m &&
                 tilt <= params_.tilt_tolerance_rad;
  } else if (z > guide || lateral > kLeaveFactor * params_.lateral_tolerance_m ||
             tilt > kLeaveFactor * params_.tilt_tolerance_rad) {
    is_guided_ = false;
  }
  if (is_guided_ && has_acted_) {
    const double profile_J = SnapWork_J(acted_params_, a_m_, a_m, &is_engaged);
    const double given_J = (force_ + acted_damping_N_s_per_m_ * v_m_per_s) * (a_m - a_m_);
    ledger_J_ += given_J - profile_J;
  } else {
    ledger_J_ = 0.0;
  }
  static_cast<void>(SnapWork_J(params_, a_m, a_m, &is_engaged));  // with parameters that may have changed since
  state_ = is_guided_ && is_engaged ? 1 : 0;
}

void Snap::SetAxial(const glm::dvec3& axis_W, const glm::dvec3& p_W, double z_m, double v_m_per_s, double dt_s) {
  const double b_m = z_m + 0.5 * dt_s * v_m_per_s;
  const double way_m = b_m - a_m_;
  // A change of state is expected if the part reaches it at its present speed and also with its present acceleration.
  bool changes = state_ == 1;
  bool is_engaged = state_ == 1;
  static_cast<void>(SnapWork_J(params_, a_m_, z_m + 0.5 * dt_s * (2.0 * v_m_per_s - v_m_per_s_), &changes));
  const bool may_change = changes != is_engaged;
  const SnapForce here = SnapAxialForce(params_, is_engaged, z_m);
  double force_N = here.force_N;
  double slope_N_s_per_m = 0.25 * dt_s * here.stiffness_N_per_m;
  if (std::abs(way_m) > kShortest_m) {
    const double work_J =
        may_change ? SnapWork_J(params_, a_m_, b_m, &is_engaged)
                   : SnapAxialEnergy_J(params_, is_engaged, a_m_) - SnapAxialEnergy_J(params_, is_engaged, b_m);
    force_N = work_J / way_m;
    const double from_N = std::min(force_N, -params_.release_force_N);  // the correction must not exceed the peaks
    const double to_N = std::max(force_N, params_.engage_force_N);
    force_N = std::clamp(force_N - ledger_J_ / way_m, from_N, to_N);
  }
  // Along the guide the child slides freely; the snap's damping acts only within its travel.
  const double d = state_ == 1 || z_m < params_.travel_m ? params_.damping_N_s_per_m : 0.0;
  SetSpring(&rows()[kSnapZ], axis_W, p_W, 0.0, 0.0, d + slope_N_s_per_m);
  rows()[kSnapZ].force = force_N + slope_N_s_per_m * v_m_per_s;
  acted_damping_N_s_per_m_ = d;
  v_m_per_s_ = v_m_per_s;
}

void Snap::Prepare(const BodyView& parent, const BodyView& child, double dt_s) {
  const Place place = PlaceOf(parent, child);
  const glm::dvec3 axes_W[3] = {place.X_WJp.rotate({1, 0, 0}), place.X_WJp.rotate({0, 1, 0}),
                                place.X_WJp.rotate({0, 0, 1})};
  const glm::dvec3 p_W = place.X_WJc.translation;
  const double z = place.offset_m.z;
  const double v = glm::dot(axes_W[2], core::PointVelocity(child.V_WO, p_W - child.X_WO.translation) -
                                           core::PointVelocity(parent.V_WO, p_W - parent.X_WO.translation));
  const double a = z - 0.5 * dt_s * v;
  position_ = z;
  UpdateState(place, a, v);
  has_acted_ = is_guided_;
  a_m_ = a;
  acted_params_ = params_;
  if (!is_guided_) {
    DeactivateAll();
    return;
  }
  const double hold = Hold(z);
  const double k = hold * params_.stiffness_N_per_m;
  const double k_t = hold * params_.stiffness_Nm_per_rad;
  const double d = hold * params_.damping_N_s_per_m;
  const double d_t = d * kDampingLever_m * kDampingLever_m;
  SetSpring(&rows()[kSnapX], axes_W[0], p_W, place.offset_m.x, k, d);
  SetSpring(&rows()[kSnapY], axes_W[1], p_W, place.offset_m.y, k, d);
  for (std::size_t i = 0; i < 3; ++i) {
    SetAngularSpring(&rows()[kRotX + i], axes_W[i], place.turn_rad[static_cast<int>(i)], k_t, d_t);
  }
  SetAxial(axes_W[2], p_W, z, v, dt_s);
}

void Snap::Finish(double dt_s) {
  force_ = rows()[kSnapZ].impulse / dt_s;
}

double Snap::StoredEnergy_J(const BodyView& parent, const BodyView& child) const {
  if (!is_guided_) return 0.0;
  const Place place = PlaceOf(parent, child);
  const glm::dvec3& offset = place.offset_m;
  const double sideways_J = params_.stiffness_N_per_m * (offset.x * offset.x + offset.y * offset.y) +
                            params_.stiffness_Nm_per_rad * glm::dot(place.turn_rad, place.turn_rad);
  bool is_engaged = state_ == 1;
  static_cast<void>(SnapWork_J(params_, offset.z, offset.z, &is_engaged));  // the state at the start of the next step
  return SnapAxialEnergy_J(params_, is_engaged, offset.z) + 0.5 * Hold(offset.z) * sideways_J;
}

void Snap::ExchangeState(Checkpoint* checkpoint) {
  Mechanism::ExchangeState(checkpoint);
  checkpoint->Exchange(&is_guided_);
  checkpoint->Exchange(&has_acted_);
  checkpoint->Exchange(&a_m_);
  checkpoint->Exchange(&v_m_per_s_);
  checkpoint->Exchange(&acted_params_);
  checkpoint->Exchange(&acted_damping_N_s_per_m_);
  checkpoint->Exchange(&ledger_J_);
}

}  // namespace physics
