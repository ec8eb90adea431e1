#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <tl/expected.hpp>

#include "scene/diagnostic.hpp"
#include "tactile/electro/patterns.hpp"

namespace tactile {

// A finger's electrodes and the person who wears them, read from a file.
struct StimulatorTable {
  std::string name;
  double width_s = 80e-6;  // of each phase of a pulse
  ElectrodePlaces places{};
  std::array<SkinCalibration, kNumElectrodes> calibrations{};
};
// The table of a <stimulator> file, or all that is wrong with it.
tl::expected<StimulatorTable, std::vector<scene::Diagnostic>> ReadStimulatorTable(const std::filesystem::path& file);

// Interface of the electrodes: gives pulses, and measures the skin. Only pulses that passed a Limiter get here.
class Electrodes {
 public:
  virtual ~Electrodes() = default;
  // Impedance [Ohm] by a current that is not felt.
  virtual double Measure(std::size_t electrode) = 0;
  // Impedance as seen during the pulse.
  virtual double Give(std::int64_t now_ns, std::size_t electrode, const Pulse& pulse) = 0;
};

// SIMULATED: skin whose impedance a test can change, and which remembers what it was given.
class SimulatedSkin final : public Electrodes {
 public:
  SimulatedSkin() { impedance_Ohm_.fill(10e3); }
  double Measure(std::size_t electrode) override { return impedance_Ohm_[electrode]; }
  double Give(std::int64_t now_ns, std::size_t electrode, const Pulse& pulse) override;

  void SetImpedance(std::size_t electrode, double impedance_Ohm) { impedance_Ohm_[electrode] = impedance_Ohm; }
  struct Given {
    std::int64_t time_ns = 0;
    std::size_t electrode = 0;
    Pulse pulse;
  };
  [[nodiscard]] const Given& last() const { return last_; }
  [[nodiscard]] std::uint64_t num_pulses() const { return num_pulses_; }

 private:
  std::array<double, kNumElectrodes> impedance_Ohm_{};
  Given last_;
  std::uint64_t num_pulses_ = 0;
};

// From what a finger touches to pulses, which pass the limiter one by one. No thread and no clock: call Turn every
// kTurn_ns.
class Stimulator {
 public:
  struct Input {
    FingerContact contact;
    double strength = 0.0;    // 0 to 1
    bool is_engaged = false;  // the dead-man is held
    std::int64_t made_ns = 0;
  };
  struct State {
    ContactKind kind = ContactKind::kNone;
    StopCause stopped_by = StopCause::kNothing;
    std::uint64_t pulses = 0;
    std::uint64_t refused = 0;
    std::array<float, kNumElectrodes> levels{};
  };

  // Both must outlive it. `limiter` begins disarmed, and is calibrated here.
  Stimulator(const StimulatorTable& table, Electrodes* electrodes, Limiter limiter);

  void Take(const Input& input) { input_ = input; }
  void Turn(std::int64_t now_ns);
  void Stop() { limiter_.Disarm(); }
  [[nodiscard]] const State& state() const { return state_; }

  static constexpr std::int64_t kTurn_ns = 1'000'000;
  static constexpr std::int64_t kSilence_ns = 40'000'000;

 private:
  bool IsReady(std::int64_t now_ns);
  void Engage(std::int64_t now_ns);
  void GiveOne(std::int64_t now_ns, const Pattern& pattern);

  StimulatorTable table_;
  Electrodes* electrodes_;
  Limiter limiter_;
  ContactClassifier classifier_;
  Input input_;
  State state_;
  std::array<std::int64_t, kNumElectrodes> due_ns_{};
};

}  // namespace tactile
