#pragma once

#include <optional>

#include "core/result.hpp"
#include "muscle/force_estimate.hpp"
#include "muscle/simulated_muscle.hpp"
#include "scene/scenario.hpp"

namespace device_bridge {

// A grip by the muscles of the forearm: how hard the fingers of a simulated device press is what the signals tell, not
// what was wanted. The signals are a generator's (<option name="muscle" value="simulated"/>): SIMULATED.
class MuscleGrip {
 public:
  // None: the device has no such option. Error: it names another source.
  static core::Result<std::optional<MuscleGrip>> Create(const scene::Device& device, std::uint64_t seed);

  // Once a tick: the strength that the person wants becomes activation, signals, and the strength that is read from
  // them. Real-time.
  double Step(double wanted_N) noexcept;

  // Of the strongest grip; none: too many faults.
  [[nodiscard]] std::optional<double> share() const { return estimate_.share(); }
  [[nodiscard]] int num_faults() const { return estimate_.num_faults(); }

  static constexpr double kStrongest_N = 60.0;  // of two fingers, an assumed person's

 private:
  // The person rests, and grips as hard as possible, before the run.
  explicit MuscleGrip(std::uint64_t seed);

  muscle::SimulatedMuscle muscle_;
  muscle::ForceEstimate estimate_;
  muscle::GripMap map_{kStrongest_N};
};

}  // namespace device_bridge
