#pragma once

#include "core/fixed_vector.hpp"
#include "core/pose.hpp"
#include "core/wrench.hpp"
#include "vps/force/penetration_sum.hpp"

namespace vps {

struct CouplingParameters {
  double stiffness_N_per_m = 2500.0;   // k_f of Eq. 6; limited by the device, scenarios set their own
  double stiffness_Nm_per_rad = 30.0;  // k_t of Eq. 6; likewise
  double eta = 0.2;                    // filter constant of Eq. 3; the paper's value
  double sigma_m2 = 0.035;             // inertia per mass of Eq. 4, the paper's value; also the metric of the advance
  double bounding_radius_m = 0.1;      // of all hand parts, about the hand frame's origin
};

// One linearised contact of the hand at its coupling pose C.
struct CouplingPlane {
  glm::dvec3 p_CoQ_W{0.0};  // contact point relative to the hand frame's origin, expressed in W
  glm::dvec3 n_W{0.0};      // unit; moving the hand's point along it opens the contact
  double gap_m = 0.0;       // negative: penetrating
  double rest_m = 0.0;      // p0: penetration that a lasting contact keeps, half a voxel of this plane's field
};

constexpr std::size_t kMaxCouplingPlanes = 96;  // not derived: almost five pairs of kMaxContactPlanes each

// Result of the collision query with the hand at X_WC, all its pairs together. CollisionWorld::HandContact fills it.
struct CouplingContact {
  PenetrationSum f_Co_W;          // f_VPS, t_VPS on the hand about its frame's origin, in W, summed in pair order
  double deepest_excess_m = 0.0;  // p - p0 of Eq. 3, of the pair for which it is largest; used when is_in_contact
  // Lower bound of the way of all points that `planes` do not cover to the rest depth: their distance and p0.
  double free_distance_m = 1e9;
  bool is_in_contact = false;
  core::FixedVector<CouplingPlane, kMaxCouplingPlanes> planes;  // penetrating and near ones
};

// The hand as contact allows it: god-object heuristic of VR-OOS, Eq. 3-6 and Fig. 7, one per hand. Deviations from the
// printed form, each with its reason, are listed in libs/vps/LEDGER.md. Allocates nothing.
class VirtualCoupling {
 public:
  explicit VirtualCoupling(const CouplingParameters& parameters = {}) : parameters_(parameters) {}

  // Puts C on D: at the start, or when the hand is let go.
  void Reset(const core::Pose& X_WD) { X_WC_ = X_WD; }

  // Pose at which collision is to be evaluated next, and at which viewers draw the hand.
  [[nodiscard]] const core::Pose& X_WC() const { return X_WC_; }
  [[nodiscard]] const CouplingParameters& parameters() const { return parameters_; }
  void set_parameters(const CouplingParameters& parameters) { parameters_ = parameters; }

  // One haptic cycle: `contact` was found at X_WC(); moves C and returns F_Do_W of Eq. 5 and 6, zero when C is on D.
  core::Wrench Step(const core::Pose& X_WD, const CouplingContact& contact);

 private:
  CouplingParameters parameters_;
  core::Pose X_WC_;
};

// Eq. 4 in the form that stays finite (derived in the .cpp): Delta x (a unitless vector, at most 1 long) and Delta phi
// [1/m], from f [m] and its moment [m^2] in one frame.
struct SeparationStep {
  glm::dvec3 delta_x{0.0};
  glm::dvec3 delta_phi_per_m{0.0};
};
SeparationStep ComputeSeparationStep(const PenetrationSum& f, double sigma_m2);

// Eq. 5 and 6: the wrench of the coupling spring on the hand about its frame's origin, in W.
core::Wrench CouplingWrench(const CouplingParameters& parameters, const core::Pose& X_WD, const core::Pose& X_WC);

}  // namespace vps
