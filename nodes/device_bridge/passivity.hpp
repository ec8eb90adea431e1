#pragma once

#include <cstdint>

#include "core/wrench.hpp"
#include "nodes/device_bridge/device.hpp"

namespace device_bridge {

struct PassivityParameters {
  double mass_kg = 1.5;
  double inertia_kg_m2 = 0.03;
  double stiffness_N_per_m = 2500.0;  // of the coupling that renders the force
  double stiffness_Nm_per_rad = 30.0;
  double most_per_s = 100.0;  // of the damping per mass: a tenth of m / T, stable up to delays of ten periods
};

// Time-domain passivity observer and controller [Hannaford & Ryu 2002] of the force on one hand: the simulated world
// may not return more energy than the hand has put into it. Energy
//   E = -sum (F . dx + tau . dphi)
// counts what was written to the device over the way that it has really moved. When E < 0 the controller adds a viscous
// wrench, the same share a of mass and inertia, F = -a m v, tau = -a I w, that takes -E in one period:
//   a = min(-E / (T (m v^2 + I w^2)), a_max).
// Without a cap it would itself be unstable. The jaws' axis is not in it. Real-time safe.
//
// Several hands of a person meet the same world, and what one puts in may come out at another: who holds a part feels
// what the other pushes into it. So E is the sum over the hands of a bridge.
//
// While a force is being withdrawn or ramped up, the world is not the one that the hand works on, and the device
// brakes: the account then stands at what a spring with the coupling's stiffness holds, F^2 / 2 k, and goes on from
// there.
class Passivity {
 public:
  explicit Passivity(const PassivityParameters& parameters) : parameters_(parameters) {}

  // `acted` was on the device from the last call until this one, when it was read. Returns what to add to the command.
  // `is_in_full`: the force is neither withdrawn nor ramped. `others_J`: energy_J of the other hands, and what weights
  // have given (ReleasedWeight).
  core::Wrench Step(const DeviceReading& reading, const core::Wrench& acted, bool is_in_full,
                    double others_J = 0.0) noexcept;

  [[nodiscard]] double energy_J() const { return energy_J_; }  // put in by this hand, not yet returned to it
  [[nodiscard]] double least_energy_J() const { return least_energy_J_; }  // E
  [[nodiscard]] std::uint64_t num_steps() const { return num_steps_; }
  [[nodiscard]] std::uint64_t num_acting() const { return num_acting_; }

 private:
  PassivityParameters parameters_;
  core::Pose X_WD_;
  double energy_J_ = 0.0;
  double least_energy_J_ = 0.0;
  std::uint64_t num_steps_ = 0;
  std::uint64_t num_acting_ = 0;
};

}  // namespace device_bridge
