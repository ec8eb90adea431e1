#pragma once

#include <span>

#include "core/pose.hpp"
#include "core/wrench.hpp"
#include "vps/coupling/contact_memory.hpp"
#include "vps/coupling/nearest_point.hpp"
#include "vps/coupling/tool_metric.hpp"

namespace vps {

// What collision found with the tool at X_WC.
struct ToolContact {
  double free_distance_m = 1e9;  // lower bound of the distance beyond the points that `planes` stand for
  core::FixedVector<ToolPlane, kMaxToolPlanes> planes;
};

// The hand as contact allows it: the tool's pose that is nearest to the device's, in the metric A, under all contact
// planes and with friction at those that carry. See god_object.cpp for the equations. One per hand. Allocates nothing,
// and its results depend on nothing but what it was given since Reset.
class GodObject {
 public:
  explicit GodObject(const GodObjectParameters& parameters = {}) : parameters_(parameters), metric_(parameters) {}

  // Puts C on D: at the start, or when the hand is let go.
  void Reset(const core::Pose& X_WD);

  // Pose at which collision is to be evaluated next, and at which viewers draw the hand.
  [[nodiscard]] const core::Pose& X_WC() const { return X_WC_; }
  [[nodiscard]] const GodObjectParameters& parameters() const { return parameters_; }
  // From the next Step on. A tool without mass takes the same way with any stiffness of the same ratio.
  void SetStiffness(double stiffness_N_per_m, double stiffness_Nm_per_rad) {
    parameters_.stiffness_N_per_m = stiffness_N_per_m;
    parameters_.stiffness_Nm_per_rad = stiffness_Nm_per_rad;
    metric_ = ToolMetric(parameters_);
  }
  void LimitDamping(double most_N_s_per_m, double most_Nm_s_per_rad) {
    parameters_.most_damping_N_s_per_m = most_N_s_per_m;
    parameters_.most_damping_Nm_s_per_rad = most_Nm_s_per_rad;
    metric_ = ToolMetric(parameters_);
  }
  [[nodiscard]] double damping_N_s_per_m() const { return metric_.damping_N_s_per_m(); }
  // Of the last Step, with the forces on the tool, at its new pose.
  [[nodiscard]] std::span<const HeldContact> contacts() const { return memory_.contacts(); }
  [[nodiscard]] bool has_mass() const { return parameters_.mass_kg > 0.0; }

  // One haptic cycle: `contact` was found at X_WC() with the bodies at X_WO; moves C and returns F_Do_W, zero when C is
  // on D.
  core::Wrench Step(const core::Pose& X_WD, const ToolContact& contact, std::span<const core::Pose> X_WO) noexcept;

 private:
  [[nodiscard]] core::Pose FreePose(const core::Pose& X_WD) const;
  [[nodiscard]] core::Wrench CouplingWrench(const core::Pose& X_WC_found, const core::Pose& X_WD) const;

  GodObjectParameters parameters_;
  ToolMetric metric_;
  ContactMemory memory_;
  core::Pose X_WC_;
  // Of the last cycle; a tool with mass has the velocity between the two.
  core::Pose X_WC_before_;
  core::Pose X_WD_before_;
};

// What a tool without mass exerts on the device at X_WD: the projection that GodObject::Step makes, once, about X_WC,
// where `contacts` are linearised. On entry they have the forces from which it starts, on return those at X_WD. The
// parameters must be those of `metric`. Allocates nothing.
core::Wrench ContactWrench(const GodObjectParameters& parameters, const ToolMetric& metric, const core::Pose& X_WC,
                           const core::Pose& X_WD, std::span<HeldContact> contacts) noexcept;

}  // namespace vps
