#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/result.hpp"

namespace tactile {

constexpr std::size_t kNumElectrodes = 8;  // of a finger

// Bounds of a stimulator. A pulse has two phases of opposite sign, each `width` long, so no charge stays in the skin.
// The peak is this project's choice; the density is what AS 60601.2.10 advises, 2 mA/cm2; width and area are the
// paper's electrodes [VR-OOS, section 4]. **Not a medical device, and not certified as one.**
struct StimulationLimits {
  double peak_A = 5.0e-3;
  double width_s = 99.0e-6;            // of a phase: below 100 us, whatever rounds
  double charge_C = 0.3e-6;            // of a phase
  double rms_A_per_m2 = 20.0;          // over any second, of an electrode
  double area_m2 = 2.54e-3 * 1.28e-3;  // of an electrode
  double rate_Hz = 400.0;              // of an electrode: pulses are at least its inverse apart
};

// Of one electrode on one person's skin [A]. Currents stay below pain by a tenth.
struct SkinCalibration {
  double threshold_A = 0.0;  // felt from here on
  double comfort_A = 0.0;    // strongest that is asked for
  double pain_A = 0.0;
};
bool IsUsable(const SkinCalibration& calibration);

struct Pulse {
  double current_A = 0.0;
  double width_s = 0.0;  // of each phase
};

enum class StopCause : std::uint8_t { kNothing, kImpedanceJumped, kOpenElectrode, kNotProvedSafe, kSilence };
const char* NameOf(StopCause cause);  // "stopped by an open electrode"

// The last code before the electrodes. It bounds what it is asked for, and refuses what it cannot prove safe: a number
// that is not finite, a time that runs backwards, an electrode that is not calibrated, or whose impedance was not
// measured since its last pulse. It can be tightened, never loosened or bypassed. A jump of impedance, or an open
// electrode, stops all electrodes with the next pulse, until they were disarmed. No allocation.
class Limiter {
 public:
  // Error: a limit is not a number above zero, or above the default, which is the most.
  static core::Result<Limiter> Create(const StimulationLimits& limits);

  // The person wants to feel something; currents grow to what they may be within kRamp_ns. Does nothing while armed, or
  // at a time below zero.
  void Arm(std::int64_t now_ns);
  // No current. Impedances must be measured anew, and what has stopped it is forgotten.
  void Disarm();
  // Also disarms: what a person bears changes only while there is no current. False, and none then: it is not usable.
  bool Calibrate(std::size_t electrode, const SkinCalibration& calibration);
  // Of the skin under the electrode, as the device measures it: before the first pulse, and with each pulse.
  void TakeImpedance(std::size_t electrode, double impedance_Ohm);
  // No current until it was disarmed. The first cause is kept.
  void Stop(StopCause cause);

  // The pulse that may be given now in place of the wanted one; none: refused.
  std::optional<Pulse> Bound(std::int64_t now_ns, std::size_t electrode, const Pulse& wanted);

  [[nodiscard]] bool is_armed() const { return is_armed_; }
  [[nodiscard]] StopCause stopped_by() const { return stopped_by_; }

  static constexpr std::int64_t kRamp_ns = 200'000'000;
  static constexpr std::int64_t kWindow_ns = 1'000'000'000;  // of the r.m.s.
  // Between any two pulses, so that currents of electrodes never add: two phases, and as much again.
  static constexpr std::int64_t kApart_ns = 400'000;
  static constexpr double kShareOfPain = 0.9;
  static constexpr double kMostJump = 1.5;  // of impedance, from one pulse to the next, up or down
  // Beyond, the electrode has come off; below, it is shorted. Skin and gel lie between [Akhtar 2018].
  static constexpr double kOpen_Ohm = 200e3;
  static constexpr double kShort_Ohm = 500.0;

 private:
  explicit Limiter(const StimulationLimits& limits) : limits_(limits) {}

  // Heat of a pulse, the share of the r.m.s. that it takes.
  struct Spent {
    std::int64_t time_ns = 0;
    double A2s = 0.0;
  };
  // At the highest rate, no more pulses lie in a window, and the one before it.
  static constexpr std::size_t kMostPulses = 402;
  struct Electrode {
    std::optional<SkinCalibration> calibration;
    double impedance_Ohm = 0.0;  // 0: not measured since it was armed
    bool is_fresh = false;       // measured since the last pulse
    std::array<Spent, kMostPulses> spent{};
    std::size_t first = 0, count = 0;
    std::int64_t pulsed_ns = 0;
    bool has_pulsed = false;
  };
  [[nodiscard]] bool IsProvedSafe(std::int64_t now_ns, std::size_t electrode, const Pulse& wanted) const;
  [[nodiscard]] double Ceiling_A(std::int64_t now_ns, const Electrode& electrode) const;
  double HeatLeft_A2s(std::int64_t now_ns, Electrode* electrode) const;

  StimulationLimits limits_;
  std::array<Electrode, kNumElectrodes> electrodes_;
  bool is_armed_ = false;
  StopCause stopped_by_ = StopCause::kNothing;
  std::int64_t armed_ns_ = 0;
  std::int64_t pulsed_ns_ = 0;  // of any electrode
  bool has_pulsed_ = false;
};

}  // namespace tactile
