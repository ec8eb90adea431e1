#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <random>
#include <string>

#include "hug/arm_model.hpp"
#include "nodes/device_bridge/devices/make_device.hpp"
#include "nodes/device_bridge/testing/filter_promises.hpp"
#include "nodes/device_bridge/testing/wire_peers.hpp"

namespace device_bridge {

// What a hostile source got done.
struct HostileOutcome {
  std::map<std::string, std::uint64_t> broken;  // promises, and how often
  std::uint64_t num_acting = 0;                 // samples with force: a filter that blocks everything would have none
  std::uint64_t num_braked = 0;
  std::uint64_t num_samples = 0;
};

// A source of commands of any bit patterns, NaN, 1e300, sequences that repeat and go back, times that reverse.
class HostileSource {
 public:
  explicit HostileSource(std::uint64_t seed) : random_(seed) {}

  std::uint64_t Below(std::uint64_t count) { return random_() % count; }
  bool OneIn(std::uint64_t count) { return Below(count) == 0; }
  double AnyDouble() {
    const std::uint64_t bits = random_();
    if (bits % 4 == 0) {
      const std::uint64_t pattern = random_();
      double value = 0.0;
      std::memcpy(&value, &pattern, sizeof value);
      return value;
    }
    if (bits % 4 == 1) return bits % 8 < 4 ? 1e300 : -1e300;
    return (static_cast<double>(random_() % 2001) - 1000.0) * 0.1;
  }
  // Up to `largest` in each axis.
  glm::dvec3 Vector(double largest) {
    const auto axis = [&] { return (static_cast<double>(Below(2001)) / 1000.0 - 1.0) * largest; };
    return {axis(), axis(), axis()};
  }
  // A command that is not finite is a fault which stays, so a stream with them soon ends.
  core::DeviceCommand Command(bool is_finite) {
    const auto value = [&] {
      const double any = AnyDouble();
      return is_finite && !std::isfinite(any) ? 1e300 : any;
    };
    core::DeviceCommand command;
    command.header.sequence = OneIn(8) ? random_() : ++sequence_;
    if (OneIn(16)) command.header.direct = {random_(), static_cast<std::int64_t>(random_()), {}};
    for (int axis = 0; axis < 3; ++axis) {
      command.F_Do_W.force_N[axis] = value();
      command.F_Do_W.torque_Nm[axis] = value();
    }
    command.grip_force_N = value();
    if (OneIn(8)) command.validity_ns = static_cast<std::int64_t>(random_());
    return command;
  }
  void BeginAgain() { sequence_ = 0; }

 private:
  std::mt19937_64 random_;
  std::uint64_t sequence_ = 0;
};

// A device that is attacked.
class AttackedDevice {
 public:
  virtual ~AttackedDevice() = default;
  virtual Device& device() = 0;
  // Once a tick: what the hand at it does.
  virtual void Move(HostileSource* source, std::int64_t now_ns) = 0;
  // What it broke of its own limits, after a sample; null: nothing.
  virtual const char* Check(const FilterLimits& limits) = 0;
  // Another specimen, untouched.
  virtual void BeginAgain(const FilterLimits& limits) = 0;
  [[nodiscard]] virtual int ticks() const = 0;  // of an attack
  [[nodiscard]] virtual std::uint64_t flood() const { return 4; }
};

// With an arm that is simulated, and its operator's. `control`: of HUG.
class AttackedArm final : public AttackedDevice {
 public:
  explicit AttackedArm(const std::string& type, const std::string& control = "") : type_(type), control_(control) {}
  Device& device() override { return *device_; }
  void BeginAgain(const FilterLimits& limits) override {
    scene::Device figures;
    figures.role = "right";
    figures.type = type_;
    figures.max_force_N = limits.max_force_N;
    figures.max_torque_Nm = limits.max_torque_Nm;
    if (!control_.empty()) figures.options.emplace_back("control", control_);
    auto made = MakeDevice(figures, std::nullopt);
    ASSERT_TRUE(made) << made.error().detail;
    device_ = std::move(*made);
    limits_ = limits;
    hand_ = {};
    hand_.X_WT = figures.X_WD_start;
  }
  // The hand pulls about, and lets the dead-man go now and then.
  void Move(HostileSource* source, std::int64_t now_ns) override {
    hand_.holds_dead_man = now_ns / 1'000'000 % 4'000 < 3'900;
    if (source->OneIn(200)) hand_.X_WT.translation = source->Vector(0.05);
    device_->SetHand(hand_);
    if (!device_->can_lead()) return;
    const LeadGoal goal{{{1, 0, 0, 0}, {source->AnyDouble(), 0, 0}}, limits_.max_force_N, limits_.max_torque_Nm};
    device_->Lead(source->OneIn(3) ? &goal : nullptr);
  }
  const char* Check(const FilterLimits& limits) override {
    const oos_device_state& state = device_->state();
    for (const double value : state.X_BD) {
      if (!std::isfinite(value)) return "a pose that is a number";
    }
    const core::Wrench applied = WrenchIn(state.applied);
    if (!(glm::length(applied.force_N) <= limits.max_force_N * (1 + 1e-12))) return "force of the motors";
    if (!(glm::length(applied.torque_Nm) <= limits.max_torque_Nm * (1 + 1e-12))) return "torque of the motors";
    if (!(std::abs(state.applied[6]) <= limits.max_grip_force_N)) return "grip force of the motor";
    oos_device_joints joints{};
    if (type_ != "hug" || !device_->Joints(&joints)) return nullptr;
    for (std::size_t i = 0; i < hug::kJoints; ++i) {
      if (!(std::abs(joints.joints[i].commanded_Nm) <= model_.max_torque[i])) return "torque of a joint";
      // An encoder's step beyond the end stop.
      if (!(std::abs(joints.joints[i].position_rad) <= model_.limit[i] + 1e-3)) return "angle of a joint";
    }
    return nullptr;
  }
  [[nodiscard]] int ticks() const override { return type_ == "hug" ? 8000 : 1000; }
  [[nodiscard]] std::uint64_t flood() const override { return type_ == "simulated_arm" ? 20 : 100; }

 private:
  static core::Wrench WrenchIn(const double* f) { return {{f[0], f[1], f[2]}, {f[3], f[4], f[5]}}; }

  std::string type_, control_;
  std::unique_ptr<Device> device_;
  HandTarget hand_;
  FilterLimits limits_;
  hug::ArmModel model_ = hug::LightWeightRobot({});
};

// No device, but what the filter is told of one: it moves at any speed, is let go, or says that it is nowhere.
class AttackedFilter final : public AttackedDevice {
 public:
  Device& device() override { return device_; }
  void BeginAgain(const FilterLimits& /*limits*/) override { device_.reading = {}; }
  void Move(HostileSource* source, std::int64_t now_ns) override {
    DeviceReading& reading = device_.reading;
    reading.is_engaged = now_ns / 1'000'000 % 200 < 150 && !source->OneIn(32);
    if (source->OneIn(20)) {
      const double speed = source->OneIn(2) ? 0.3 : 2.0;
      reading.V_WD = {source->Vector(5.0 * speed), source->Vector(speed)};
    }
    if (source->OneIn(2000)) reading.V_WD.angular_rad_per_s.x = source->AnyDouble();
    if (source->OneIn(2000)) reading.V_WD.linear_m_per_s.x = source->AnyDouble();
  }
  const char* Check(const FilterLimits& /*limits*/) override { return nullptr; }
  [[nodiscard]] int ticks() const override { return 1000; }

 private:
  struct NoDevice final : Device {
    DeviceReading Read(std::int64_t /*now_ns*/) noexcept override { return reading; }
    void Write(std::int64_t /*now_ns*/, const FilteredForce& /*force*/) noexcept override {}
    [[nodiscard]] std::uint64_t num_found() const noexcept override { return 1; }
    [[nodiscard]] const oos_device_description& description() const noexcept override { return description_; }
    [[nodiscard]] const DeviceHealth& Health(std::int64_t /*now_ns*/) noexcept override { return health_; }
    [[nodiscard]] const oos_device_state& state() const noexcept override { return state_; }

    DeviceReading reading;

   private:
    oos_device_description description_{};
    oos_device_state state_{};
    DeviceHealth health_;
  };
  NoDevice device_;
};

// Made of a scenario's device, without a thread.
inline std::unique_ptr<Device> MakeThreadless(const scene::Device& figures) {
  ThreadedOptions options;
  options.has_thread = false;
  auto made = MakeDevice(figures, options);
  if (made) return std::move(*made);
  ADD_FAILURE() << made.error().detail;
  return nullptr;
}

// At the end of a link, on a virtual clock. It moves at any speed.
template <class P>
class AttackedPeer final : public AttackedDevice {
 public:
  Device& device() override { return *device_; }
  void BeginAgain(const FilterLimits& /*limits*/) override {
    device_.reset();
    peer_.reset();
    peer_ = std::make_unique<P>();
    scene::Device figures;
    figures.role = "right";
    peer_->Name(&figures);
    device_ = MakeThreadless(figures);
    ASSERT_TRUE(device_);
  }
  void Move(HostileSource* source, std::int64_t now_ns) override {
    peer_->SetEngaged(now_ns / 1'000'000 % 1'000 < 900);
    if (source->OneIn(50)) {
      const double speed = source->OneIn(2) ? 0.2 : 2.0;
      peer_->SetTwist({source->Vector(5.0 * speed), source->Vector(speed)});
    }
    peer_->Serve(now_ns);
  }
  const char* Check(const FilterLimits& limits) override {
    constexpr double kRounding = 1.0 + 1e-12;  // of another frame
    const ToldCommand& told = peer_->told();
    if (!(glm::length(told.F_Do_B.force_N) <= limits.max_force_N * kRounding)) return "force that it was told";
    if (!(glm::length(told.F_Do_B.torque_Nm) <= limits.max_torque_Nm * kRounding)) return "torque that it was told";
    if (!(std::abs(told.grip_force_N) <= limits.max_grip_force_N)) return "grip force that it was told";
    if (!(told.brake_N_s_per_m >= 0.0 && told.brake_N_s_per_m <= limits.brake_N_s_per_m))
      return "brake that it was told";
    if (!(told.brake_Nm_s_per_rad >= 0.0 && told.brake_Nm_s_per_rad <= limits.brake_Nm_s_per_rad)) {
      return "brake in rotation that it was told";
    }
    return nullptr;
  }
  [[nodiscard]] int ticks() const override { return 1000; }
  [[nodiscard]] std::uint64_t flood() const override { return 100; }

 private:
  std::unique_ptr<P> peer_;
  std::unique_ptr<Device> device_;
};

// The shared library of the how-to, which applies what it is commanded.
class AttackedPlugin final : public AttackedDevice {
 public:
  Device& device() override { return *device_; }
  void BeginAgain(const FilterLimits& /*limits*/) override {
    scene::Device figures;
    figures.role = "right";
    figures.type = "plugin";
    figures.address = VR_OOS_BINARY_DIR "/test_plugins/own_device.so";
    device_ = MakeThreadless(figures);
    ASSERT_TRUE(device_);
  }
  void Move(HostileSource* /*source*/, std::int64_t /*now_ns*/) override {}
  const char* Check(const FilterLimits& limits) override {
    const double* f = device_->state().applied;
    if (!(glm::length(glm::dvec3(f[0], f[1], f[2])) <= limits.max_force_N * (1.0 + 1e-12))) return "force it applies";
    return nullptr;
  }
  [[nodiscard]] int ticks() const override { return 1000; }
  [[nodiscard]] std::uint64_t flood() const override { return 100; }

 private:
  std::unique_ptr<Device> device_;
};

struct AttackCase {
  const char* name;
  std::unique_ptr<AttackedDevice> (*make)();
};
inline const AttackCase kAttackCases[] = {
    {"filter", [] { return std::unique_ptr<AttackedDevice>(new AttackedFilter); }},
    {"simulated_arm", [] { return std::unique_ptr<AttackedDevice>(new AttackedArm("simulated_arm")); }},
    {"simulated_hug", [] { return std::unique_ptr<AttackedDevice>(new AttackedArm("simulated_hug")); }},
    {"hug_impedance", [] { return std::unique_ptr<AttackedDevice>(new AttackedArm("hug", "impedance")); }},
    {"hug_admittance", [] { return std::unique_ptr<AttackedDevice>(new AttackedArm("hug", "admittance")); }},
    {"hug_guidance", [] { return std::unique_ptr<AttackedDevice>(new AttackedArm("hug", "guidance")); }},
    {"udp", [] { return std::unique_ptr<AttackedDevice>(new AttackedPeer<UdpPeer>); }},
    {"serial", [] { return std::unique_ptr<AttackedDevice>(new AttackedPeer<SerialPeer>); }},
    {"haply", [] { return std::unique_ptr<AttackedDevice>(new AttackedPeer<HaplyPeer>); }},
    {"plugin", [] { return std::unique_ptr<AttackedDevice>(new AttackedPlugin); }},
};

// Gives a device `count` hostile commands through the filter, floods of them between two samples, and looks after each
// sample whether a promise of the filter or a limit of the device was broken.
inline HostileOutcome Attack(AttackedDevice* attacked, std::uint64_t count, std::uint64_t seed) {
  HostileSource source(seed);
  HostileOutcome outcome;
  std::uint64_t sent = 0;
  while (sent < count) {
    std::int64_t now_ns = 1'000'000'000;  // a device that is new goes through all time before
    FilterLimits limits;
    limits.max_force_N = 1.0 + static_cast<double>(source.Below(100));
    limits.max_torque_Nm = std::min(20.0, 0.1 * limits.max_force_N);
    limits.max_grip_force_N = 1.0 + static_cast<double>(source.Below(50));
    limits.max_force_rate_N_per_s = source.OneIn(2) ? 20'000.0 : 500.0;
    limits.start_ramp_ns = limits.restart_ramp_ns = 1'000'000;
    SafetyFilter filter = *SafetyFilter::Create(limits);
    FilterPromises promises(limits);
    attacked->BeginAgain(limits);
    source.BeginAgain();
    const bool is_finite = !source.OneIn(4);
    for (int tick = 0; tick < attacked->ticks(); ++tick) {
      now_ns += 1'000'000;
      attacked->Move(&source, now_ns);
      // Now and then the source falls silent for as long as the force should be gone.
      const bool is_silent = tick % 700 > 600;
      const std::uint64_t flood = is_silent ? 0 : source.Below(2 * attacked->flood());
      for (std::uint64_t i = 0; i < flood; ++i) {
        const core::DeviceCommand command = source.Command(is_finite || tick < attacked->ticks() * 3 / 4);
        const std::int64_t received_ns =
            source.OneIn(8) ? now_ns - static_cast<std::int64_t>(source.Below(1'000'000'000)) : now_ns;
        filter.Accept(command, received_ns);
        ++sent;
        if (!filter.was_accepted()) continue;
        const std::int64_t origin_ns = command.header.direct.origin_ns;
        const bool is_older = command.header.direct.valid() && origin_ns < received_ns - limits.hold_ns;
        promises.NoteAccepted(is_older ? origin_ns + limits.hold_ns : received_ns);
      }
      const std::int64_t at_ns =
          source.OneIn(32) ? now_ns - static_cast<std::int64_t>(source.Below(1'000'000)) : now_ns;
      const DeviceReading reading = attacked->device().Read(at_ns);
      const core::Wrench added{{source.AnyDouble(), 0, 0}, {0, 0, source.AnyDouble()}};
      const FilteredForce force = filter.Apply(at_ns, reading, added);
      attacked->device().Write(at_ns, force);
      const char* broken = promises.Check(at_ns, reading, filter.status(), force);
      if (broken == nullptr) broken = attacked->Check(limits);
      if (broken != nullptr) ++outcome.broken[broken];
      ++outcome.num_samples;
      outcome.num_acting += glm::length(force.F_Do_W().force_N) > 0.0 ? 1 : 0;
      outcome.num_braked += force.brake_Nm_s_per_rad() > 0.0 ? 1 : 0;
    }
  }
  return outcome;
}

}  // namespace device_bridge
