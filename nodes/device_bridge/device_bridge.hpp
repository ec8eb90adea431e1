#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/result.hpp"
#include "nodes/device_bridge/allowed_coupling.hpp"
#include "nodes/device_bridge/contact_field.hpp"
#include "nodes/device_bridge/devices/make_device.hpp"
#include "nodes/device_bridge/echo_log.hpp"
#include "nodes/device_bridge/loop_delay.hpp"
#include "nodes/device_bridge/operator/guide.hpp"
#include "nodes/device_bridge/operator/muscle_grip.hpp"
#include "nodes/device_bridge/operator/pointer_hand.hpp"
#include "nodes/device_bridge/operator/simulated_operator.hpp"
#include "nodes/device_bridge/passivity.hpp"
#include "nodes/device_bridge/ports.hpp"
#include "nodes/device_bridge/presence.hpp"
#include "nodes/device_bridge/released_weight.hpp"
#include "nodes/device_bridge/rendered_impulse.hpp"
#include "nodes/device_bridge/safety_filter.hpp"
#include "scene/scenario.hpp"

namespace device_bridge {

struct Options {
  OperatorOptions operator_options;
  // Clock for stamps and for writes between ticks. Null: virtual time, which is now_ns of the step or of the call.
  std::int64_t (*clock)() = nullptr;
  bool is_person_steering = false;  // by a viewer (PointerHand), in place of the scripted operator
  // Capacity for echoes; 0: enough for the scenario's duration limit.
  std::size_t num_echoes = 0;
  // For devices that live in real time; none: only simulated arms are possible (lock-step).
  std::optional<ThreadedOptions> threads;
  bool is_made_passive = true;  // false: for measurements of the boundary of stability, which the controller hides
};

// Statistics of one role over the run.
struct RoleFigures {
  double peak_force_N = 0.0;
  double peak_torque_Nm = 0.0;
  double peak_grip_force_N = 0.0;
  std::uint64_t writes = 0;              // number of force samples
  std::uint64_t samples_over_limit = 0;  // samples above the force limit; 0 unless the filter fails
  std::uint64_t samples_in_force = 0;    // samples above 0.1 N, well above the rounding of a zero force
  std::uint64_t commands_accepted = 0;
  std::uint64_t commands_refused = 0;
  std::uint64_t status_samples[32] = {};  // writes with bit i of FilterStatus set
  std::uint64_t link_losses = 0;          // times that the force was faded out because commands stopped
  // Largest age of the newest accepted command in a sample with force: below 60 ms in every run.
  double oldest_force_ms = 0.0;
  std::uint32_t first_cause = 0;
  std::int64_t first_cause_ns = 0;
  double loop_delay_s = 0.0;  // from sample to force; 0: not measured
  double loop_jitter_s = 0.0;
  AllowedCoupling allowed;             // by the latest delay
  double stiffness_share = 0.0;        // allowed over wanted stiffness; 0: not measured
  double least_stiffness_share = 0.0;  // in this run
  double energy_J = 0.0;               // of the passivity observer
  double least_energy_J = 0.0;
  std::uint64_t samples_made_passive = 0;  // writes in which its controller acted
  [[nodiscard]] double share_made_passive() const {
    return writes == 0 ? 0.0 : static_cast<double>(samples_made_passive) / static_cast<double>(writes);
  }
};

// The node without sockets, clock or threads: devices, safety filter, simulated operator and echo log. Call Step once
// per tick; between ticks AcceptCommand passes a command to the device as soon as it has arrived.
class DeviceBridge {
 public:
  // Errors: kUnsupported for an unknown device type or too many devices; kInvalidInput for invalid limits or a script
  // with errors (all are listed).
  static core::Result<std::unique_ptr<DeviceBridge>> Create(const scene::Scenario& scenario, std::uint64_t seed,
                                                            const Options& options = {});
  static core::Result<std::unique_ptr<DeviceBridge>> Create(const scene::Scenario& scenario) {
    return Create(scenario, scenario.seed);
  }
  DeviceBridge(const DeviceBridge&) = delete;
  DeviceBridge& operator=(const DeviceBridge&) = delete;

  // One tick: accepts new commands, advances the devices to now_ns, filters and writes the force, steps the operator,
  // samples. Real-time: no allocation, lock, throw or log. The outputs' states carry a direct trace whose origin is the
  // sample time.
  void Step(const Inputs& inputs, Outputs* outputs) noexcept;

  // Passes a command through the filter to the device at once, between ticks. A message that was passed before (same
  // sequence and arrival) is ignored, so the caller may pass the newest one repeatedly.
  void AcceptCommand(std::size_t role, const core::DeviceCommand& command, std::int64_t received_ns,
                     std::int64_t now_ns) noexcept;

  [[nodiscard]] const scene::Scenario& scenario() const { return scenario_; }
  [[nodiscard]] const EchoLog& echo_log() const { return echo_log_; }
  [[nodiscard]] const SimulatedOperator& simulated_operator() const { return *operator_; }
  [[nodiscard]] RoleFigures figures(std::size_t role) const;
  [[nodiscard]] double force_limit_N(std::size_t role) const { return roles_[role]->filter.limits().max_force_N; }
  // Allowed over wanted stiffness of the coupling; 0: not measured yet.
  [[nodiscard]] double stiffness_share(std::size_t role) const { return roles_[role]->stiffness_share; }
  [[nodiscard]] const AllowedCoupling& allowed(std::size_t role) const { return roles_[role]->allowed; }
  [[nodiscard]] const Device& device(std::size_t role) const { return *roles_[role]->device; }
  // How soon it noticed that a device was lost or back.
  [[nodiscard]] const Presence& presence(std::size_t role) const { return roles_[role]->presence; }
  // As of the latest step.
  [[nodiscard]] const DeviceHealth& health(std::size_t role) const { return roles_[role]->health; }
  // Of a role whose fingers press as the muscles tell; none: another.
  [[nodiscard]] const MuscleGrip* muscle(std::size_t role) const {
    return roles_[role]->muscle ? &*roles_[role]->muscle : nullptr;
  }
  // Of a role whose device is a robot; false for others.
  bool Joints(std::size_t role, core::DeviceJoints* joints) const noexcept;
  // What a person who steers does next; none: nobody steers.
  [[nodiscard]] const Tip* tip(std::size_t role) const { return guide_ ? &guide_->tip(role) : nullptr; }
  [[nodiscard]] std::uint64_t ticks() const { return ticks_; }

 private:
  struct Role {
    std::unique_ptr<Device> device;
    std::uint64_t num_found = 0;  // devices that this role has had, one after another
    SafetyFilter filter;
    ContactField field;
    DeviceReading reading;
    DeviceHealth health;
    Presence presence;
    FilteredForce written;
    RenderedImpulse impulse;
    RoleFigures figures;
    std::uint64_t passed_sequence = 0;
    std::int64_t passed_received_ns = 0;
    std::uint64_t sample_sequence = 0;
    bool was_silent = true;
    std::int64_t accepted_ns = 0;  // arrival of the newest accepted command
    LoopDelay loop_delay;
    AllowedCoupling allowed;
    double stiffness_share = 0.0;
    double least_stiffness_share = 0.0;
    Passivity passivity;
    std::optional<MuscleGrip> muscle;
    bool is_led = false;  // to `goal`
    LeadGoal goal;
    Role(const SafetyFilter& f, const scene::Device& d, const scene::Coupling& c)
        : filter(f),
          loop_delay(d.command_delay_s),
          passivity({d.mass_kg, d.inertia_kg_m2, c.stiffness_N_per_m, c.stiffness_Nm_per_rad}) {}
  };

  DeviceBridge(const scene::Scenario& scenario, const Options& options, std::size_t num_samples)
      : scenario_(scenario), options_(options), echo_log_(scenario.devices.size(), num_samples) {}
  // Another device was plugged in: its own limits hold, too, and its mass counts.
  void TakeDescription(std::size_t role_index) noexcept;
  // Where whoever moves simulated devices wants a hand, with the strength that its muscles tell.
  [[nodiscard]] HandTarget Target(std::size_t role_index) noexcept;
  // Reads, lets the force follow the device, filters, writes, and updates the statistics. `accepted`: a new command.
  void Write(Role* role, std::int64_t now_ns, const core::DeviceCommand* accepted = nullptr) noexcept;
  void UpdateAllowedCoupling(std::size_t role_index) noexcept;
  void StepOperator(const Inputs& inputs, const core::FixedVector<FeltForce, kMaxRoles>& felt,
                    const core::FixedVector<DeviceReading, kMaxRoles>& readings) noexcept;
  [[nodiscard]] bool CanLead() const noexcept;
  void LeadHands(bool can_lead) noexcept;
  [[nodiscard]] std::int64_t Now(std::int64_t now_ns) const {
    return options_.clock != nullptr ? options_.clock() : now_ns;
  }

  scene::Scenario scenario_;
  Options options_;
  EchoLog echo_log_;
  std::vector<std::unique_ptr<Role>> roles_;
  std::unique_ptr<SimulatedOperator> operator_;
  bool has_hands_ = false;  // a device is moved by an operator without a device
  std::optional<PointerHand> pointer_;
  std::optional<Guide> guide_;  // of the person
  bool is_guided_ = false;      // by the scripted operator
  std::uint64_t ticks_ = 0;
  // Newest physics state and its arrival. A force fades when physics_node stops; before its first message, the age of
  // physics does not limit the force.
  std::uint64_t physics_sequence_ = 0;
  std::int64_t physics_alive_ns_ = std::numeric_limits<std::int64_t>::max();
  ReleasedWeight released_weight_;
};

}  // namespace device_bridge
