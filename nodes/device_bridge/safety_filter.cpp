#include "nodes/device_bridge/safety_filter.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace device_bridge {
namespace {

// Upper bounds for the limits of any device, whatever a scenario says. 150 N is the static force limit of ISO
// 10218-1:2006 for collaborative robots; torque and rate are chosen by judgement.
constexpr double kAbsoluteMaxForce_N = 150.0;
constexpr double kAbsoluteMaxTorque_Nm = 20.0;
constexpr double kAbsoluteMaxRate_N_per_s = 1.0e6;
// Ascending sequence numbers that identify a restarted source. Judgement: stray old datagrams rarely come in order, and
// 3 ticks of delay are short against the restart ramp.
constexpr int kRestartStreak = 3;

constexpr std::int64_t kLongAgo_ns = 3'600'000'000'000;

bool IsFinite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Scales v down to the limit, keeping its direction: v min(1, limit / |v|). It divides by the largest component first,
// since the square of 1e300 overflows.
glm::dvec3 Shorten(const glm::dvec3& v, double limit, bool* is_limited) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (largest <= 0.0) return v;
  const glm::dvec3 scaled = v / largest;
  const double norm = glm::length(scaled);  // in [1, sqrt 3]
  if (norm * largest <= limit) return v;
  *is_limited = true;
  // 1e-14 below the limit, so that rounding cannot exceed it.
  return scaled * (limit * (1.0 - 1e-14) / norm);
}

// Moves from `from` towards `to` by at most `step`.
glm::dvec3 Approach(const glm::dvec3& from, const glm::dvec3& to, double step, bool* is_limited) {
  const glm::dvec3 change = to - from;
  bool is_far = false;
  const glm::dvec3 shortened = Shorten(change, step, &is_far);
  if (!is_far) return to;
  *is_limited = true;
  return from + shortened;
}

}  // namespace

FilterLimits FilterLimits::From(const scene::Device& device, double force_cap_N) {
  FilterLimits limits;
  limits.max_force_N = std::min(device.max_force_N, force_cap_N);
  limits.max_torque_Nm = device.max_torque_Nm;
  limits.max_grip_force_N = device.max_force_N;
  limits.max_force_rate_N_per_s = device.max_force_rate_N_per_s;
  return limits;
}

core::Result<SafetyFilter> SafetyFilter::Create(const FilterLimits& limits) {
  const auto check = [](double value, double greatest) {
    return std::isfinite(value) && value >= 0.0 && value <= greatest;
  };
  const auto fail = [](const std::string& what, double value, double greatest, const char* unit) {
    return core::Fail(core::ErrorCode::kInvalidInput, "safety filter: " + what + " is " + std::to_string(value) + " " +
                                                          unit + "; give a figure from 0 to " +
                                                          std::to_string(greatest));
  };
  if (!check(limits.max_force_N, kAbsoluteMaxForce_N))
    return fail("max_force_N", limits.max_force_N, kAbsoluteMaxForce_N, "N");
  if (!check(limits.max_torque_Nm, kAbsoluteMaxTorque_Nm)) {
    return fail("max_torque_Nm", limits.max_torque_Nm, kAbsoluteMaxTorque_Nm, "Nm");
  }
  if (!check(limits.max_grip_force_N, kAbsoluteMaxForce_N)) {
    return fail("max_grip_force_N", limits.max_grip_force_N, kAbsoluteMaxForce_N, "N");
  }
  if (!check(limits.max_force_rate_N_per_s, kAbsoluteMaxRate_N_per_s)) {
    return fail("max_force_rate_N_per_s", limits.max_force_rate_N_per_s, kAbsoluteMaxRate_N_per_s, "N/s");
  }
  if (!check(limits.max_power_W, 1000.0)) return fail("max_power_W", limits.max_power_W, 1000.0, "W");
  if (!check(limits.max_speed_m_per_s, 10.0)) return fail("max_speed_m_per_s", limits.max_speed_m_per_s, 10.0, "m/s");
  if (!check(limits.soft_speed_m_per_s, 10.0))
    return fail("soft_speed_m_per_s", limits.soft_speed_m_per_s, 10.0, "m/s");
  if (!check(limits.brake_N_s_per_m, 1e4)) return fail("brake_N_s_per_m", limits.brake_N_s_per_m, 1e4, "N s/m");
  if (!check(limits.brake_Nm_s_per_rad, 1e3))
    return fail("brake_Nm_s_per_rad", limits.brake_Nm_s_per_rad, 1e3, "Nm s/rad");
  // Times may only be shortened: without commands the force must be zero after 60 ms at the latest.
  SafetyFilter filter(FilterLimits{});
  FilterLimits taken = limits;
  taken.hold_ns = std::clamp<std::int64_t>(limits.hold_ns, 0, filter.limits_.hold_ns);
  taken.fade_ns = std::clamp<std::int64_t>(limits.fade_ns, 0, filter.limits_.fade_ns);
  taken.release_fade_ns = std::clamp<std::int64_t>(limits.release_fade_ns, 0, filter.limits_.release_fade_ns);
  filter.limits_ = taken;
  return filter;
}

void SafetyFilter::Tighten(const FilterLimits& limits) noexcept {
  const auto smaller = [](double* mine, double other) {
    if (std::isfinite(other) && other >= 0.0) *mine = std::min(*mine, other);
  };
  smaller(&limits_.max_force_N, limits.max_force_N);
  smaller(&limits_.max_torque_Nm, limits.max_torque_Nm);
  smaller(&limits_.max_grip_force_N, limits.max_grip_force_N);
  smaller(&limits_.max_force_rate_N_per_s, limits.max_force_rate_N_per_s);
  smaller(&limits_.soft_speed_m_per_s, limits.soft_speed_m_per_s);
  smaller(&limits_.max_speed_m_per_s, limits.max_speed_m_per_s);
  smaller(&limits_.max_power_W, limits.max_power_W);
  limits_.hold_ns = std::clamp<std::int64_t>(limits.hold_ns, 0, limits_.hold_ns);
  limits_.fade_ns = std::clamp<std::int64_t>(limits.fade_ns, 0, limits_.fade_ns);
  limits_.release_fade_ns = std::clamp<std::int64_t>(limits.release_fade_ns, 0, limits_.release_fade_ns);
  limits_.start_ramp_ns = std::max(limits_.start_ramp_ns, limits.start_ramp_ns);
  limits_.restart_ramp_ns = std::max(limits_.restart_ramp_ns, limits.restart_ramp_ns);
}

void SafetyFilter::Accept(const core::DeviceCommand& command, std::int64_t received_ns,
                          std::int64_t backed_until_ns) noexcept {
  was_accepted_ = false;
  const std::uint64_t sequence = command.header.sequence;
  if (sequence == 0) return;  // has never arrived
  // A number above all before is new. A restarted source counts from 1 again: after silence it is accepted once its
  // numbers have ascended kRestartStreak times in a row, which stray old datagrams do not.
  restart_streak_ = sequence > streak_sequence_ ? restart_streak_ + 1 : 1;
  streak_sequence_ = sequence;
  const bool is_restart = may_restart_ && sequence != last_sequence_ && restart_streak_ >= kRestartStreak;
  const bool is_new = sequence > last_sequence_ || is_restart;
  // The command counts as fresh from its arrival, or from the device sample that it was computed from plus the hold,
  // whichever is earlier. So a sample time in the future has no effect.
  std::int64_t alive_ns = std::min(received_ns, backed_until_ns);
  if (command.header.direct.valid()) {
    // Not so long ago, nor so far ahead, that a sum or a difference of times would overflow.
    const std::int64_t origin_ns = std::clamp(command.header.direct.origin_ns, received_ns - kLongAgo_ns, received_ns);
    alive_ns = std::min(alive_ns, origin_ns + limits_.hold_ns);
  }
  const bool is_older = has_command_ && alive_ns < alive_ns_;
  if (!is_new || is_older || command.validity_ns <= 0) {
    was_refused_ = true;
    ++num_refused_;
    return;
  }
  last_sequence_ = sequence;
  may_restart_ = false;
  if (!IsFinite(command.F_Do_W.force_N) || !IsFinite(command.F_Do_W.torque_Nm) ||
      !std::isfinite(command.grip_force_N)) {
    has_fault_ = true;
    ++num_refused_;
    return;
  }
  command_ = command.F_Do_W;
  grip_command_N_ = command.grip_force_N;
  alive_ns_ = alive_ns;
  hold_ns_ = std::min(limits_.hold_ns, command.validity_ns);
  has_command_ = true;
  was_accepted_ = true;
  ++num_accepted_;
}

// With the command's age t: 1 for t <= hold, then 1 - (t - hold) / fade, and 0 from hold + fade on. It stays 0 until a
// new command starts the ramp.
double SafetyFilter::AgeFactor(std::int64_t now_ns) noexcept {
  if (!has_command_) {
    status_ |= kNoCommand;
    return 0.0;
  }
  const std::int64_t over_ns = now_ns - alive_ns_ - hold_ns_;
  if (over_ns <= 0) return 1.0;
  status_ |= kDegraded;
  if (over_ns < limits_.fade_ns) return 1.0 - static_cast<double>(over_ns) / static_cast<double>(limits_.fade_ns);
  status_ |= kSilent;
  // The next command may come from a restarted source that counts from 1 again.
  may_restart_ = true;
  gain_ = 0.0;
  is_restart_ = true;
  return 0.0;
}

void SafetyFilter::AdvanceGain(std::int64_t dt_ns, bool may_act) noexcept {
  if (may_act) {
    const std::int64_t ramp_ns = is_restart_ ? limits_.restart_ramp_ns : limits_.start_ramp_ns;
    gain_ = ramp_ns <= 0 ? 1.0 : std::min(1.0, gain_ + static_cast<double>(dt_ns) / static_cast<double>(ramp_ns));
    if (gain_ < 1.0) status_ |= kStarting;
    return;
  }
  const std::int64_t ramp_ns = limits_.release_fade_ns;
  gain_ = ramp_ns <= 0 ? 0.0 : std::max(0.0, gain_ - static_cast<double>(dt_ns) / static_cast<double>(ramp_ns));
  if (gain_ <= 0.0) is_restart_ = false;
}

FilteredForce SafetyFilter::Apply(std::int64_t now_ns, const DeviceReading& reading,
                                  const core::Wrench& added) noexcept {
  if (has_sample_) now_ns = std::max(now_ns, last_ns_);
  const std::int64_t dt_ns = has_sample_ ? std::min<std::int64_t>(now_ns - last_ns_, 10'000'000) : 0;
  last_ns_ = now_ns;
  has_sample_ = true;
  status_ = was_refused_ ? kRefused : kFilterOk;
  was_refused_ = false;

  // 1 Finite. A device whose reading is not finite gets no force either.
  const double speed = glm::length(reading.V_WD.linear_m_per_s);
  const bool is_reading_finite =
      std::isfinite(speed) && IsFinite(reading.V_WD.angular_rad_per_s) && IsFinite(reading.X_WD.translation);
  if (!is_reading_finite) has_fault_ = true;
  if (!reading.is_engaged && is_reading_finite && gain_ <= 0.0) has_fault_ = false;  // releasing clears a fault
  if (has_fault_) status_ |= kNotFinite;
  if (!reading.is_engaged) status_ |= kDeadMan;

  // 2 Age, and 3 the ramps of dead-man, fault and start.
  const double age_factor = AgeFactor(now_ns);
  if (has_command_ && (status_ & kSilent) == 0) AdvanceGain(dt_ns, reading.is_engaged && !has_fault_);
  const double factor = age_factor * gain_;

  // 4 Norm limits.
  const core::Wrench wanted = IsFinite(added.force_N) && IsFinite(added.torque_Nm) ? command_ + added : command_;
  bool is_force_limited = false;
  bool is_torque_limited = false;
  const glm::dvec3 force_N = factor * Shorten(wanted.force_N, limits_.max_force_N, &is_force_limited);
  const glm::dvec3 torque_Nm = factor * Shorten(wanted.torque_Nm, limits_.max_torque_Nm, &is_torque_limited);
  const double grip_N = factor * std::clamp(grip_command_N_, -limits_.max_grip_force_N, limits_.max_grip_force_N);
  if (is_force_limited) status_ |= kForceLimited;
  if (is_torque_limited) status_ |= kTorqueLimited;
  if (std::abs(grip_command_N_) > limits_.max_grip_force_N) status_ |= kGripLimited;

  // 5 Rate. While the force is withdrawn, the rate is at least that which removes it within the release time.
  const double dt_s = static_cast<double>(dt_ns) * 1e-9;
  const bool is_taking_away = (status_ & (kDegraded | kDeadMan | kNotFinite)) != 0;
  double rate =
      limits_.max_force_N > 0.0 ? limits_.max_force_rate_N_per_s / limits_.max_force_N : 0.0;  // limits per second
  if (is_taking_away) rate = std::max(rate, 1.0e9 / std::max(1.0, static_cast<double>(limits_.release_fade_ns)));
  bool is_rate_limited = false;
  core::Wrench out;
  out.force_N = Approach(output_.force_N, force_N, rate * limits_.max_force_N * dt_s, &is_rate_limited);
  out.torque_Nm = Approach(output_.torque_Nm, torque_Nm, rate * limits_.max_torque_Nm * dt_s, &is_rate_limited);
  const double grip_step_N = rate * limits_.max_grip_force_N * dt_s;
  double grip_out_N = std::clamp(grip_N, grip_output_N_ - grip_step_N, grip_output_N_ + grip_step_N);
  if (is_rate_limited || grip_out_N != grip_N) status_ |= kRateLimited;
  if (is_taking_away) {
    // And no more than what is left of the limits: a command that jumps about meanwhile leads the output astray.
    bool is_shortened = false;
    out.force_N = Shorten(out.force_N, factor * limits_.max_force_N, &is_shortened);
    out.torque_Nm = Shorten(out.torque_Nm, factor * limits_.max_torque_Nm, &is_shortened);
    const double grip_left_N = factor * limits_.max_grip_force_N;
    grip_out_N = std::clamp(grip_out_N, -grip_left_N, grip_left_N);
  }

  // 6 Power into the hand, P = F.v + tau.w [W]; force and torque are scaled by the same factor P_max / P.
  FilteredForce result;
  if (is_reading_finite) {
    const double power_W =
        glm::dot(out.force_N, reading.V_WD.linear_m_per_s) + glm::dot(out.torque_Nm, reading.V_WD.angular_rad_per_s);
    if (power_W > limits_.max_power_W) {
      out = (limits_.max_power_W / power_W) * out;
      status_ |= kPowerLimited;
    }
    // 7 Velocity: above the soft limit the device brakes, above the hard limit it gets the brake alone.
    if (speed > limits_.soft_speed_m_per_s) {
      status_ |= kVelocityBraked;
      result.brake_N_s_per_m_ = limits_.brake_N_s_per_m;
      result.brake_Nm_s_per_rad_ = limits_.brake_Nm_s_per_rad;
      if (speed > limits_.max_speed_m_per_s) {
        out = core::Wrench{};
        grip_out_N = 0.0;
      }
    }
  }
  if ((status_ & (kDegraded | kNotFinite)) != 0 || is_restarting()) {
    result.brake_N_s_per_m_ = limits_.brake_N_s_per_m;
    result.brake_Nm_s_per_rad_ = limits_.brake_Nm_s_per_rad;
  }

  // 8 Check the result again, independently of the stages above: zero without commands, norms within their limits.
  if ((status_ & (kSilent | kNoCommand)) != 0 || !is_reading_finite || !IsFinite(out.force_N) ||
      !IsFinite(out.torque_Nm)) {
    out = core::Wrench{};
    grip_out_N = 0.0;
  }
  bool ignored = false;
  out.force_N = Shorten(out.force_N, limits_.max_force_N, &ignored);
  out.torque_Nm = Shorten(out.torque_Nm, limits_.max_torque_Nm, &ignored);
  grip_out_N = std::clamp(grip_out_N, -limits_.max_grip_force_N, limits_.max_grip_force_N);

  constexpr std::uint32_t kCauses = kNotFinite | kDegraded | kDeadMan;
  if (first_cause_ == 0 && (status_ & kCauses) != 0) {
    first_cause_ = status_ & kCauses;
    first_cause_ns_ = now_ns;
  }
  output_ = out;
  grip_output_N_ = grip_out_N;
  result.F_Do_W_ = out;
  result.grip_force_N_ = grip_out_N;
  return result;
}

}  // namespace device_bridge
