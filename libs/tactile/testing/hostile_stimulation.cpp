#include "tactile/testing/hostile_stimulation.hpp"

#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <random>

#include "tactile/electro/limiter.hpp"

namespace tactile {
namespace {

// What nobody may exceed, in the units of the literature, and written anew: nothing here is the limiter's. Differences
// of times are in microseconds.
class SkinOracle {
 public:
  void Calibrate(std::size_t electrode, double pain_mA, bool is_usable) {
    if (electrode < 8) pain_mA_[electrode] = is_usable ? pain_mA : 0.0;
    Rest();  // while a person is calibrated no current flows
  }
  // No current flows, and nothing is known of the skin from then on.
  void Rest() {
    must_rest_ = false;
    is_armed_ = false;
    ohm_.fill(0.0);
  }
  void Arm(std::int64_t now_ns) {
    if (!is_armed_) armed_ns_ = now_ns;
    is_armed_ = true;
  }
  // True: from now on no pulse may come.
  bool TakeImpedance(std::size_t electrode, double ohm) {
    const bool is_wrong = electrode >= 8 || !(ohm >= 500.0 && ohm <= 200'000.0);
    const bool has_jumped =
        !is_wrong && ohm_[electrode] > 0.0 && std::abs(std::log(ohm / ohm_[electrode])) > std::log(1.5) + 1e-9;
    if (electrode < 8 && !is_wrong && !has_jumped) ohm_[electrode] = ohm;
    const bool is_new = (is_wrong || has_jumped) && !must_rest_;
    must_rest_ = must_rest_ || is_wrong || has_jumped;
    return is_new;
  }

  // What is wrong with a pulse that came through; empty: nothing.
  std::string Judge(std::int64_t now_ns, std::size_t electrode, double mA, double us) {
    if (!is_armed_) return "while disarmed";
    if (must_rest_) return "after impedance has jumped, or an electrode was open";
    if (electrode >= 8) return "at no electrode";
    if (!(pain_mA_[electrode] > 0.0)) return "at an electrode without calibration";
    if (!(ohm_[electrode] > 0.0)) return "into unknown skin";
    if (!(mA > 0.0) || !(us > 0.0)) return "that is none";
    if (!(us < 100.0)) return "of 100 us or more";
    if (mA > 5.0 * kRounding) return "above 5 mA";
    if (mA > 0.9 * pain_mA_[electrode] * kRounding) return "near pain";
    if (mA * us > 300.0 * kRounding) return "of more than 0.3 uC";  // mA us = nC
    const double ramp = Us(now_ns - armed_ns_) / 200'000.0;
    if (mA > ramp * 5.0 * kRounding) return "at full current too early";
    if (has_given_ && Us(now_ns - last_ns_) < 399.0) return "that overlaps another";
    last_ns_ = now_ns;
    has_given_ = true;
    std::deque<Given>& given = given_[electrode];
    if (!given.empty() && Us(now_ns - given.back().time_ns) < 2'499.0) return "faster than 400 Hz";
    given.push_back({now_ns, mA * mA * 2.0 * us});
    while (Us(now_ns - given.front().time_ns) > 1e6) given.pop_front();
    double heat_mA2us = 0.0;
    for (const Given& pulse : given) heat_mA2us += pulse.heat_mA2us;
    // 2 mA/cm2 on 2.54 mm x 1.28 mm, over a second.
    const double most_mA = 2.0 * 0.254 * 0.128;
    return std::sqrt(heat_mA2us / 1e6) > most_mA * kRounding ? "above 2 mA/cm2" : "";
  }

 private:
  static double Us(std::int64_t ns) { return static_cast<double>(ns) * 1e-3; }

  static constexpr double kRounding = 1.0 + 1e-9;
  struct Given {
    std::int64_t time_ns;
    double heat_mA2us;
  };
  std::array<double, 8> pain_mA_{};  // 0: not known
  std::array<double, 8> ohm_{};
  std::array<std::deque<Given>, 8> given_;
  bool is_armed_ = false;
  bool must_rest_ = false;
  std::int64_t armed_ns_ = 0;
  bool has_given_ = false;
  std::int64_t last_ns_ = 0;
};

class Attack {
 public:
  explicit Attack(std::uint64_t seed) : random_(seed) {
    for (std::size_t i = 0; i < 8; ++i) Calibrate(i, {0.3e-3, 0.7e-3, 1.2e-3});
  }

  HostileOutcome Run(std::uint64_t num_calls) {
    for (std::uint64_t i = 0; i < num_calls && outcome_.first_wrong.empty(); ++i) Call();
    return outcome_;
  }

 private:
  double Uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  // Mostly of a plausible size, sometimes anything.
  double Number(double typical) {
    constexpr double kOdd[] = {0.0,
                               -1.0,
                               1e300,
                               -1e300,
                               1e-300,
                               std::numeric_limits<double>::infinity(),
                               -std::numeric_limits<double>::infinity(),
                               std::numeric_limits<double>::quiet_NaN()};
    const double kind = Uniform(0.0, 1.0);
    if (kind < 0.05) return kOdd[random_() % std::size(kOdd)];
    if (kind < 0.2) return typical * std::pow(10.0, Uniform(-3.0, 3.0));
    return typical * Uniform(0.2, 2.0);
  }
  // One draw for each statement here and below: compilers differ in the order within one.
  std::size_t Electrode() {
    const std::size_t num = Uniform(0.0, 1.0) < 0.01 ? 100 : 8;
    return random_() % num;
  }

  void Call() {
    PassTime();
    const double kind = Uniform(0.0, 1.0);
    const bool is_off = !limiter_.is_armed() || limiter_.stopped_by() != StopCause::kNothing;
    if (is_off && kind < 0.1) return Restart();
    if (kind < 0.9) return Command();
    const std::size_t electrode = Electrode();
    if (kind < 0.985) return Measure(electrode, Uniform(0.0, 1.0) < 0.1 ? Number(10e3) : Uniform(9e3, 11e3));
    if (kind < 0.991) return Calibrate(electrode, {Number(0.3e-3), Number(0.7e-3), Number(2e-3)});
    if (kind < 0.994) return Disarm();
    Arm();
  }
  // In bursts and pauses; now and then the clock runs backwards.
  void PassTime() {
    const double kind = Uniform(0.0, 1.0);
    if (kind < 0.002) now_ns_ -= static_cast<std::int64_t>(Uniform(0.0, 1e9));
    now_ns_ += static_cast<std::int64_t>(kind > 0.999 ? Uniform(0.0, 2e9) : Uniform(0.0, 1.5e6));
  }
  // The device measures with each pulse. Skin jumps in one of a thousand, and then it rests, as a person would have it.
  void Command() {
    const std::size_t electrode = Electrode();
    const Pulse wanted{Number(1e-3), Number(80e-6)};
    const auto pulse = limiter_.Bound(now_ns_, electrode, wanted);
    if (!pulse) return;
    ++outcome_.pulses;
    const std::string wrong = oracle_.Judge(now_ns_, electrode, pulse->current_A * 1e3, pulse->width_s * 1e6);
    if (!wrong.empty()) {
      outcome_.first_wrong = "pulse " + std::to_string(outcome_.pulses) + " " + wrong + ": " +
                             std::to_string(pulse->current_A * 1e3) + " mA, " + std::to_string(pulse->width_s * 1e6) +
                             " us";
    }
    if (Uniform(0.0, 1.0) < 0.95) Measure(electrode, Uniform(0.0, 1.0) < 0.001 ? Number(10e3) : Uniform(9e3, 11e3));
  }
  // A person releases the dead-man and presses it again.
  void Restart() {
    Disarm();
    for (std::size_t i = 0; i < 8; ++i) Measure(i, Uniform(9e3, 11e3));
    Arm();
    for (std::size_t i = 0; i < 8; ++i) {
      if (Uniform(0.0, 1.0) < 0.05) Calibrate(i, {0.3e-3, 0.7e-3, Uniform(0.9e-3, 20e-3)});
    }
  }
  void Measure(std::size_t electrode, double ohm) {
    limiter_.TakeImpedance(electrode, ohm);
    if (oracle_.TakeImpedance(electrode, ohm)) ++outcome_.stops;
  }
  void Calibrate(std::size_t electrode, const SkinCalibration& c) {
    const bool is_usable = limiter_.Calibrate(electrode, c);
    const bool makes_sense =
        c.threshold_A > 0.0 && c.threshold_A < c.comfort_A && c.comfort_A < 0.9 * c.pain_A && std::isfinite(c.pain_A);
    if (is_usable && !makes_sense) outcome_.first_wrong = "a calibration that makes no sense was taken";
    oracle_.Calibrate(electrode, c.pain_A * 1e3, is_usable);
  }
  void Arm() {
    limiter_.Arm(now_ns_);
    oracle_.Arm(now_ns_);
  }
  void Disarm() {
    limiter_.Disarm();
    oracle_.Rest();
  }

  std::mt19937_64 random_;
  Limiter limiter_ = *Limiter::Create({});
  SkinOracle oracle_;
  HostileOutcome outcome_;
  std::int64_t now_ns_ = 5'000'000'000;
};

}  // namespace

HostileOutcome RunHostileStimulation(std::uint64_t num_calls, std::uint64_t seed) {
  return Attack(seed).Run(num_calls);
}

}  // namespace tactile
