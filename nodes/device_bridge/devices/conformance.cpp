#include "nodes/device_bridge/devices/conformance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

#include "core/clock.hpp"
#include "nodes/device_bridge/devices/plugin_values.hpp"
#include "nodes/device_bridge/safety_filter.hpp"

namespace device_bridge {
namespace {

constexpr std::int64_t kComes_ns = 5'000'000'000;  // for the device to come
constexpr std::int64_t kLook_ns = 2'000'000'000;   // longer than two windows of LinkMeter
// Free choices, so that the whole check takes some eight seconds: a push comes to rest in its first half, two seconds
// have two thousand hostile commands, and a mute lasts more than twice the watchdog.
constexpr std::int64_t kPush_ns = 1'500'000'000;
constexpr std::int64_t kHostile_ns = 2'000'000'000;
constexpr double kLeadWay_m = 0.02;  // to where it leads: within any workspace
constexpr std::int64_t kMuted_ns = 150'000'000;
constexpr double kWatchdog_s = 0.06;  // of device/plugin.h
// One sample and its way later than the watchdog.
constexpr double kWatchdogGrace_s = 0.015;
constexpr double kReach_m = 5.0;         // of a device that does not tell: none reaches further
constexpr double kSpeed_m_per_s = 20.0;  // no hand is faster
// A free choice: K < 2 b / T leaves at 5 ms a fifth of the stiffness at 1 ms, and steps are felt.
constexpr double kMinRate_hz = 200.0;

std::string Text(const char* format, double a, double b = 0.0) {
  char text[200];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

class ConformanceChecker {
 public:
  ConformanceChecker(Device* device, const ConformanceOptions& options)
      : device_(*device), options_(options), filter_(*SafetyFilter::Create(Limits(options.force_N))) {}

  std::vector<ConformanceFinding> Check() {
    if (!Appears()) return findings_;
    TakeLimits();
    Look();
    if (MayPush()) {
      Push();
      LeadAway();
      Provoke();
      FallSilent();
    }
    return findings_;
  }

 private:
  static FilterLimits Limits(double force_N) {
    FilterLimits limits;
    limits.max_force_N = force_N;
    limits.max_torque_Nm = 0.1 * force_N;  // with a lever of 0.1 m the same
    limits.max_grip_force_N = force_N;
    limits.start_ramp_ns = 200'000'000;
    return limits;
  }

  void Add(const char* subject, bool holds, std::string what, const std::string& remedy) {
    if (!holds) what += ". " + remedy;
    findings_.push_back({subject, holds ? Verdict::kHolds : Verdict::kFails, std::move(what)});
  }
  void Skip(const char* subject, std::string why) { findings_.push_back({subject, Verdict::kSkipped, std::move(why)}); }

  // One millisecond: reads the device, filters, writes.
  void Tick() {
    next_ns_ = std::max(next_ns_ + core::kTick_ns, options_.clock());
    options_.wait_until(next_ns_);
    const std::int64_t now_ns = options_.clock();
    reading_ = device_.Read(now_ns);
    device_.Write(now_ns, filter_.Apply(now_ns, reading_));
    const oos_device_state& state = device_.state();
    is_new_ = state.sequence != sequence_;
    sequence_ = state.sequence;
  }
  template <class During>
  void For(std::int64_t duration_ns, const During& during) {
    const std::int64_t end_ns = options_.clock() + duration_ns;
    while (options_.clock() < end_ns && !options_.is_interrupted()) {
      Tick();
      during();
    }
  }
  void Command(const glm::dvec3& force_N) {
    core::DeviceCommand command;
    command.header.sequence = ++num_commands_;
    command.F_Do_W.force_N = force_N;
    filter_.Accept(command, options_.clock());
  }
  [[nodiscard]] double Applied_N() const { return glm::length(WrenchOf(device_.state().applied).force_N); }

  bool Appears() {
    const std::int64_t begin_ns = options_.clock();
    DeviceStatus status = DeviceStatus::kWaiting;
    while (status != DeviceStatus::kAlive && status != DeviceStatus::kBroken && !options_.is_interrupted() &&
           options_.clock() - begin_ns < kComes_ns) {
      Tick();
      status = device_.Health(options_.clock()).status;
    }
    const bool is_there = status == DeviceStatus::kAlive;
    const DeviceHealth& health = device_.Health(options_.clock());
    std::string what = std::string("it is ") + NameOf(status);
    if (health.why[0] != 0) what += std::string(": ") + health.why.data();
    if (is_there) what = std::string(device_.description().name) + ", serial number " + device_.description().serial;
    Add("found", is_there, what, "It must send a description and states; is the address right?");
    return is_there;
  }

  void TakeLimits() {
    const oos_device_description& d = device_.description();
    FilterLimits limits = filter_.limits();
    if (d.max_force_N > 0.0) limits.max_force_N = d.max_force_N;
    if (d.max_torque_Nm > 0.0) limits.max_torque_Nm = d.max_torque_Nm;
    if (d.max_grip_force_N > 0.0) limits.max_grip_force_N = d.max_grip_force_N;
    filter_.Tighten(limits);
  }

  // Without force: the link, and whether the numbers are metres, seconds and unit quaternions.
  void Look() {
    double reach_m = 0.0, fastest = 0.0;
    double told = 0.0, difference = 0.0;  // squares of velocities, and of their difference from the poses'
    std::optional<core::Pose> before;
    std::int64_t before_ns = 0, first_device_ns = 0, first_ns = 0, last_device_ns = 0, last_ns = 0;
    bool is_time_reversed = false;
    For(kLook_ns, [&] {
      if (!is_new_) return;
      const oos_device_state& state = device_.state();
      const core::Pose X_BD = PoseOf(state.X_BD);
      const core::Twist V_BD = TwistOf(state.V_BD);
      reach_m = std::max(reach_m, glm::length(X_BD.translation));
      fastest = std::max(fastest, glm::length(V_BD.linear_m_per_s));
      is_time_reversed = is_time_reversed || state.device_time_ns < last_device_ns;
      const double dt_s = static_cast<double>(state.device_time_ns - before_ns) * 1e-9;
      if (before && dt_s > 0.0) {
        const glm::dvec3 seen = (X_BD.translation - before->translation) / dt_s;
        told += glm::dot(V_BD.linear_m_per_s, V_BD.linear_m_per_s);
        const glm::dvec3 apart = V_BD.linear_m_per_s - seen;
        difference += glm::dot(apart, apart);
      }
      before = X_BD;
      before_ns = last_device_ns = state.device_time_ns;
      last_ns = options_.clock();
      if (first_ns == 0) {
        first_ns = last_ns;
        first_device_ns = state.device_time_ns;
      }
    });
    const oos_device_description& d = device_.description();
    JudgeLink(device_.Health(options_.clock()).link, d);
    const double limit_m = d.reach_m > 0.0 ? 2.0 * d.reach_m : kReach_m;
    Add("metres", reach_m <= limit_m && fastest <= kSpeed_m_per_s,
        Text("up to %.3g m from its base, up to %.3g m/s", reach_m, fastest),
        Text("More than %.3g m: are these millimetres?", limit_m));
    const double device_s = static_cast<double>(last_device_ns - first_device_ns) * 1e-9;
    const double here_s = static_cast<double>(last_ns - first_ns) * 1e-9;
    const double pace = here_s > 0.0 ? device_s / here_s : 0.0;
    Add("nanoseconds", !is_time_reversed && std::abs(pace - 1.0) < 0.05,
        Text("its clock runs %.4f times as fast as this one", pace),
        is_time_reversed ? "It goes backwards." : "It must count nanoseconds.");
    const double moved = std::sqrt(told);
    if ((d.flags & OOS_DEVICE_TELLS_VELOCITY) == 0) {
      Skip("velocity", "it gives none; the bridge differentiates the poses");
    } else if (moved < 1e-3) {
      Skip("velocity", "it stood still; move it during the check");
    } else {
      Add("velocity", difference < 0.25 * told,
          Text("differs from the change of the poses by %.2g of itself", std::sqrt(difference / told)),
          "It must be in m/s, in the base's frame, at the time of the pose.");
    }
  }

  // A tracker without motors may be slow: nobody feels its steps.
  void JudgeLink(const LinkFigures& link, const oos_device_description& d) {
    const double told_hz = d.rate_hz;
    const bool is_as_told = told_hz <= 0.0 || std::abs(link.rate_hz - told_hz) < 0.1 * told_hz;
    Add("rate", (d.actuated == 0 || link.rate_hz >= kMinRate_hz) && is_as_told,
        Text("%.0f samples a second", link.rate_hz),
        is_as_told ? Text("Below %.0f the hand feels steps.", kMinRate_hz)
                   : Text("It says that it gives %.0f.", told_hz));
    Add("jitter", link.jitter_s < 0.02, Text("the longest gap is %.2f ms longer than the mean", 1e3 * link.jitter_s),
        "Give its loop a real-time priority, and its link no other traffic.");
    Add("loss", link.loss < 0.01, Text("%.2f %% of the samples did not arrive", 1e2 * link.loss),
        "Is another device at the same address, or the line too slow?");
    if (link.round_trip_s > 0.0) {
      Add("round trip", link.round_trip_s < 0.01,
          Text("%.2f ms from a command to the sample that knows it", 1e3 * link.round_trip_s),
          "Above 10 ms walls get soft: answer at the next sample.");
    } else {
      Skip("round trip", "it does not say which command it had (reflected)");
    }
  }

  bool MayPush() {
    const oos_device_description& d = device_.description();
    std::string why;
    if (d.actuated == 0) why = "it has no motors";
    if (why.empty() && (d.flags & OOS_DEVICE_TELLS_APPLIED) == 0) why = "it does not tell what it applies";
    if (why.empty() && !reading_.is_engaged) why = "its dead-man was not held";
    if (why.empty()) return true;
    for (const char* subject : {"push", "clamp", "watchdog"}) Skip(subject, why);
    return false;
  }

  // Push 1 N, see 1 N.
  void Push() {
    const double force_N = 0.8 * filter_.limits().max_force_N;
    double sum_N = 0.0;
    int num = 0;
    const std::int64_t settled_ns = options_.clock() + kPush_ns / 2;
    For(kPush_ns, [&] {
      Command({force_N, 0, 0});
      if (!is_new_ || options_.clock() < settled_ns) return;
      sum_N += WrenchOf(device_.state().applied).force_N.x;
      ++num;
    });
    const double mean_N = num > 0 ? sum_N / num : 0.0;
    Add("push", std::abs(mean_N - force_N) < 0.1 * force_N,
        Text("of %.2f N along its x axis it applies %.2f N", force_N, mean_N),
        "It must apply F_Do_B, in N, and tell what it applies.");
  }

  // Only of a device that says that it leads. Nothing else is commanded meanwhile.
  void LeadAway() {
    if ((device_.description().flags & OOS_DEVICE_LEADS) == 0) return;
    if (!device_.can_lead()) {
      Add("lead", false, "it says that it leads", "Its table has no lead().");
      return;
    }
    const double limit_N = filter_.limits().max_force_N;
    LeadGoal goal{reading_.X_WD, limit_N, filter_.limits().max_torque_Nm};
    goal.X_WG.translation.x += kLeadWay_m;
    double largest_N = 0.0;
    For(kPush_ns, [&] {
      Command({});
      device_.Lead(&goal);
      if (is_new_) largest_N = std::max(largest_N, Applied_N());
    });
    const double left_m = glm::distance(reading_.X_WD.translation, goal.X_WG.translation);
    const double until_s = SecondsUntilForceEnds([&] {
      Command({});
      device_.Lead(nullptr);
    });
    std::string remedy;
    if (left_m > 0.5 * kLeadWay_m) remedy = "It must come nearer to the goal; let the hand go along.";
    if (largest_N > limit_N * 1.001) remedy = Text("Above %.3f N: command and guidance count together.", limit_N);
    if (until_s > kWatchdog_s + kWatchdogGrace_s) remedy = "It must let go when it is told no goal.";
    Add("lead", remedy.empty(),
        Text("%.1f mm of %.0f mm were left", 1e3 * left_m, 1e3 * kLeadWay_m) +
            Text(", with at most %.3f N, and let go after %.0f ms", largest_N, 1e3 * until_s),
        remedy);
  }

  template <class During>
  double SecondsUntilForceEnds(const During& during) {
    const std::int64_t begin_ns = options_.clock();
    double until_s = 0.0;
    For(kMuted_ns, [&] {
      during();
      const bool is_off = (device_.state().flags & OOS_DEVICE_IS_OFF) != 0;
      if (!is_off && Applied_N() > 1e-6) until_s = static_cast<double>(options_.clock() - begin_ns) * 1e-9;
    });
    return until_s;
  }

  // Whatever is commanded, the filter lets nothing above the limit pass.
  void Provoke() {
    const double limit_N = filter_.limits().max_force_N;
    const double values[] = {
        std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300, -1e300, 1e-300, 50.0};
    double largest_N = 0.0;
    std::size_t next = 0;
    For(kHostile_ns, [&] {
      for (int flood = 0; flood < 5; ++flood) {
        // A command that is not finite is a fault that stays, so most of them are finite.
        const double value = values[next % 40 == 39 && next > 6000 ? next % 2 : 2 + next % 4];
        ++next;
        Command({value, -value, 0.5 * value});
      }
      if (is_new_) largest_N = std::max(largest_N, Applied_N());
    });
    Add("clamp", largest_N <= limit_N * 1.001,
        Text("at most %.3f N were applied, %.3f N are allowed", largest_N, limit_N),
        "It applies more than it was commanded.");
  }

  // Commands stop altogether, as if the bridge had died.
  void FallSilent() {
    filter_ = *SafetyFilter::Create(Limits(options_.force_N));
    TakeLimits();
    const double force_N = 0.8 * filter_.limits().max_force_N;
    For(kPush_ns / 2, [&] { Command({force_N, 0, 0}); });
    const double before_N = Applied_N();
    if (before_N < 0.5 * force_N) {
      Skip("watchdog", "there was no force to take away");
      return;
    }
    device_.SetMuted(true);
    const double until_s = SecondsUntilForceEnds([] {});
    device_.SetMuted(false);
    Add("watchdog", until_s <= kWatchdog_s + kWatchdogGrace_s,
        Text("without commands its force was gone after %.0f ms", 1e3 * until_s),
        Text("It must be gone after %.0f ms: whoever commands may have died.", 1e3 * kWatchdog_s));
  }

  Device& device_;
  const ConformanceOptions& options_;
  SafetyFilter filter_;
  DeviceReading reading_;
  std::int64_t next_ns_ = 0;
  std::uint64_t sequence_ = 0;
  std::uint64_t num_commands_ = 0;
  bool is_new_ = false;
  std::vector<ConformanceFinding> findings_;
};

}  // namespace

std::vector<ConformanceFinding> CheckConformance(Device* device, const ConformanceOptions& options) {
  return ConformanceChecker(device, options).Check();
}

}  // namespace device_bridge
