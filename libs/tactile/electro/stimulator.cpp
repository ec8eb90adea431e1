#include "tactile/electro/stimulator.hpp"

#include <algorithm>

#include "scene/element_reader.hpp"

namespace tactile {
namespace {

using scene::ValueKind;

const std::vector<scene::ElementRule>& StimulatorRules() {
  static const std::vector<scene::ElementRule> rules = {
      {"stimulator",
       "a finger's eight electrodes, and what the person who wears them feels",
       {{"name", ValueKind::kText, true, {}}, {"width_us", ValueKind::kPositive, false, {}}},
       {{"electrode", kNumElectrodes, kNumElectrodes}}},
      {"electrode",
       "its place on the pad, and the person's threshold, comfort and pain there",
       {{"across_mm", ValueKind::kNumber, true, {}},
        {"along_mm", ValueKind::kNumber, true, {}},
        {"threshold_mA", ValueKind::kPositive, true, {}},
        {"comfort_mA", ValueKind::kPositive, true, {}},
        {"pain_mA", ValueKind::kPositive, true, {}}},
       {}},
  };
  return rules;
}

double Scaled(const scene::XmlElement& element, const char* name, double scale, double otherwise = 0.0) {
  double value = otherwise / scale;
  scene::ElementReader(element).Number(name, &value);
  return value * scale;
}

}  // namespace

tl::expected<StimulatorTable, std::vector<scene::Diagnostic>> ReadStimulatorTable(const std::filesystem::path& file) {
  const auto root = scene::ReadXml(file);
  if (!root) return tl::unexpected(root.error());
  std::vector<scene::Diagnostic> diagnostics;
  scene::CheckAgainstRules(*root, file, &diagnostics, "stimulator", StimulatorRules());
  if (!diagnostics.empty()) return tl::unexpected(std::move(diagnostics));
  StimulatorTable table;
  table.name = root->Get("name");
  table.width_s = Scaled(*root, "width_us", 1e-6, table.width_s);
  if (table.width_s > StimulationLimits{}.width_s) {
    diagnostics.push_back({{file, root->LineOf("width_us")},
                           "width_us is " + root->Get("width_us"),
                           "a phase of a pulse is shorter than 100 us",
                           "write 80"});
  }
  for (std::size_t i = 0; i < kNumElectrodes; ++i) {
    const scene::XmlElement& electrode = root->children[i];
    table.places[i] = {Scaled(electrode, "across_mm", 1e-3), Scaled(electrode, "along_mm", 1e-3)};
    table.calibrations[i] = {Scaled(electrode, "threshold_mA", 1e-3), Scaled(electrode, "comfort_mA", 1e-3),
                             Scaled(electrode, "pain_mA", 1e-3)};
    if (IsUsable(table.calibrations[i])) continue;
    diagnostics.push_back({{file, electrode.line},
                           "electrode " + std::to_string(i) + ": no usable calibration",
                           "threshold < comfort < 0.9 pain",
                           "calibrate the person anew"});
  }
  if (!diagnostics.empty()) return tl::unexpected(std::move(diagnostics));
  return table;
}

double SimulatedSkin::Give(std::int64_t now_ns, std::size_t electrode, const Pulse& pulse) {
  last_ = {now_ns, electrode, pulse};
  ++num_pulses_;
  return impedance_Ohm_[electrode];
}

Stimulator::Stimulator(const StimulatorTable& table, Electrodes* electrodes, Limiter limiter)
    : table_(table), electrodes_(electrodes), limiter_(limiter) {
  for (std::size_t i = 0; i < kNumElectrodes; ++i) limiter_.Calibrate(i, table.calibrations[i]);
}

void Stimulator::Turn(std::int64_t now_ns) {
  const bool is_ready = IsReady(now_ns);
  state_.kind = classifier_.Step(now_ns, is_ready ? input_.contact : FingerContact{});
  state_.levels = {};
  const double time_s = 1e-9 * static_cast<double>(now_ns - classifier_.since_ns());
  const Pattern pattern =
      PatternOf(state_.kind, input_.contact, std::clamp(input_.strength, 0.0, 1.0), time_s, table_.places);
  if (is_ready) GiveOne(now_ns, pattern);
  state_.stopped_by = limiter_.stopped_by();
  const bool is_silent = now_ns - input_.made_ns > kSilence_ns;
  if (state_.stopped_by == StopCause::kNothing && is_silent) state_.stopped_by = StopCause::kSilence;
}

// Releasing the dead-man takes the current away at once, and pressing it again forgets what has stopped it. Silence
// takes it away, too, and forgets nothing.
bool Stimulator::IsReady(std::int64_t now_ns) {
  const bool is_silent = now_ns - input_.made_ns > kSilence_ns;
  const bool is_stopped = limiter_.stopped_by() != StopCause::kNothing;
  if (!input_.is_engaged || (is_silent && !is_stopped)) limiter_.Disarm();
  if (!input_.is_engaged || is_silent) return false;
  if (!limiter_.is_armed()) Engage(now_ns);
  return limiter_.stopped_by() == StopCause::kNothing;
}

void Stimulator::Engage(std::int64_t now_ns) {
  for (std::size_t i = 0; i < kNumElectrodes; ++i) limiter_.TakeImpedance(i, electrodes_->Measure(i));
  limiter_.Arm(now_ns);
}

// One pulse in a turn, of the electrode that has waited longest: currents of electrodes must not add.
void Stimulator::GiveOne(std::int64_t now_ns, const Pattern& pattern) {
  std::size_t chosen = kNumElectrodes;
  for (std::size_t i = 0; i < kNumElectrodes; ++i) {
    state_.levels[i] = static_cast<float>(pattern[i].level);
    if (pattern[i].level <= 0.0 || now_ns < due_ns_[i]) continue;
    if (chosen == kNumElectrodes || due_ns_[i] < due_ns_[chosen]) chosen = i;
  }
  if (chosen == kNumElectrodes) return;
  due_ns_[chosen] = now_ns + static_cast<std::int64_t>(1e9 / pattern[chosen].rate_Hz);
  const SkinCalibration& skin = table_.calibrations[chosen];
  const double wanted_A = skin.threshold_A + pattern[chosen].level * (skin.comfort_A - skin.threshold_A);
  const auto pulse = limiter_.Bound(now_ns, chosen, {wanted_A, table_.width_s});
  if (!pulse) {
    ++state_.refused;
    return;
  }
  ++state_.pulses;
  limiter_.TakeImpedance(chosen, electrodes_->Give(now_ns, chosen, *pulse));
}

}  // namespace tactile
