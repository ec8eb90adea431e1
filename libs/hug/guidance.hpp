#pragma once

#include <optional>

#include "core/pose.hpp"
#include "core/wrench.hpp"
#include "hug/interpolator.hpp"

namespace hug {

// Of leading a hand. Weaker than an arm that holds against it: who does not want to be led is stronger.
struct GuidanceFigures {
  // A free choice of how firmly the path leads: 10 N hold the hand 33 mm beside it. Dampers are critical for the
  // virtual body with its own damping: 40 + 5 is about 2 sqrt(300 x 1.5), 1.0 + 0.05 about 2 sqrt(8 x 0.03).
  double stiffness_N_per_m = 300.0;
  double damping_N_s_per_m = 40.0;
  double stiffness_Nm_per_rad = 8.0;
  double damping_Nm_s_per_rad = 1.0;
  double max_force_N = 12.0;
  double max_torque_Nm = 1.0;
  // Largest on the path, in its middle.
  double speed_m_per_s = 0.25;
  double speed_rad_per_s = 0.8;
  // The path goes on the slower the further the hand is from it, and waits from here on.
  double wait_m = 0.04;
  double wait_rad = 0.3;
};

// Leads a hand along a path of least jerk, from where it is to a goal, by a spring and a damper between hand and path,
// with limits. So it is a force and not a place that is prescribed: a hand that pushes leaves the path, which waits for
// it.
class Guidance {
 public:
  explicit Guidance(const GuidanceFigures& figures) : figures_(figures) {}

  // A goal that moved a little moves the end of the path; one elsewhere begins a path from where the hand is.
  void LeadTo(const core::Pose& X_WG);
  void Stop();
  [[nodiscard]] bool is_on() const { return goal_.has_value(); }

  // Force on the hand frame D for the next dt, about Do in W; zero without a goal.
  core::Wrench Step(double dt_s, const core::Pose& X_WD, const core::Twist& V_WD);
  // Where the path is now; of one that is on and was stepped.
  [[nodiscard]] const core::Pose& X_WI() const { return X_WI_; }

 private:
  void Begin(const core::Pose& X_WD);
  void GoOn(double dt_s, const core::Pose& X_WD);

  GuidanceFigures figures_;
  std::optional<core::Pose> goal_;
  std::optional<Interpolator> path_;
  double time_s_ = 0.0;  // on the path
  core::Pose X_WI_;
  core::Twist V_WI_;
};

// Both parts no longer than those of `limits`, with their directions.
core::Wrench Within(const core::Wrench& F, double max_force_N, double max_torque_Nm);

}  // namespace hug
