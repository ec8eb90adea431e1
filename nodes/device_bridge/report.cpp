#include "nodes/device_bridge/report.hpp"

#include <array>
#include <fstream>
#include <nlohmann/json.hpp>

namespace device_bridge {
namespace {

constexpr std::array kStatusNames = {
    "no_command",      "not_finite",    "degraded", "silent",   "force_limited", "torque_limited", "rate_limited",
    "velocity_braked", "power_limited", "dead_man", "starting", "refused",       "grip_limited"};

nlohmann::json ToJson(const LatencySummary& s) {
  return {{"mean", s.mean_ms}, {"p50", s.p50_ms}, {"p90", s.p90_ms}, {"p99", s.p99_ms},
          {"p999", s.p999_ms}, {"max", s.max_ms}, {"n", s.n}};
}

// Null for a grip without muscles.
nlohmann::json MusclePart(const MuscleGrip* muscle) {
  if (muscle == nullptr) return nullptr;
  return {{"is_simulated", true}, {"share", muscle->share().value_or(-1.0)}, {"faults", muscle->num_faults()}};
}

const char* Text(LineOutcome outcome) {
  switch (outcome) {
    case LineOutcome::kDone:
      return "done";
    case LineOutcome::kDistanceUsedUp:
      return "distance used up";
    case LineOutcome::kAbandoned:
      return "abandoned: the step was over";
  }
  return "";
}

}  // namespace

std::vector<std::string> StatusNames(std::uint32_t status) {
  std::vector<std::string> names;
  for (std::size_t bit = 0; bit < kStatusNames.size(); ++bit) {
    if ((status >> bit) & 1U) names.emplace_back(kStatusNames[bit]);
  }
  return names;
}

nlohmann::json MakeReport(const DeviceBridge& bridge) {
  using nlohmann::json;
  json report;
  double peak_N = 0.0;
  std::uint64_t over_limit = 0;
  json roles = json::array();
  for (std::size_t i = 0; i < bridge.scenario().devices.size(); ++i) {
    const RoleFigures figures = bridge.figures(i);
    peak_N = std::max(peak_N, figures.peak_force_N);
    over_limit += figures.samples_over_limit;
    json samples = json::object();
    for (std::size_t bit = 0; bit < kStatusNames.size(); ++bit)
      samples[kStatusNames[bit]] = figures.status_samples[bit];
    const stability::Wall best =
        stability::FastestDecay(DeviceAxis(bridge.scenario().devices[i], figures.allowed.delay_s));
    roles.push_back({{"role", bridge.scenario().devices[i].role},
                     {"device", bridge.device(i).description().name},
                     {"is_simulated", bridge.device(i).is_simulated()},
                     {"force_limit_N", bridge.force_limit_N(i)},
                     {"peak_force_N", figures.peak_force_N},
                     {"peak_torque_Nm", figures.peak_torque_Nm},
                     {"peak_grip_force_N", figures.peak_grip_force_N},
                     {"samples", figures.writes},
                     {"samples_over_cap", figures.samples_over_limit},
                     {"samples_in_force", figures.samples_in_force},
                     {"commands_accepted", figures.commands_accepted},
                     {"commands_refused", figures.commands_refused},
                     {"oldest_force_ms", figures.oldest_force_ms},
                     {"link_losses", figures.link_losses},
                     {"device_losses", bridge.presence(i).num_losses()},
                     {"most_steps_to_device_lost", bridge.presence(i).most_steps_to_lost()},
                     {"most_steps_to_device_found", bridge.presence(i).most_steps_to_found()},
                     {"loop_delay_ms", 1e3 * figures.loop_delay_s},
                     {"loop_jitter_ms", 1e3 * figures.loop_jitter_s},
                     {"allowed_stiffness_N_per_m", figures.allowed.stiffness_N_per_m},
                     {"allowed_stiffness_Nm_per_rad", figures.allowed.stiffness_Nm_per_rad},
                     {"allowed_stiffness_by_linear_rule_N_per_m", figures.allowed.linear_stiffness_N_per_m},
                     {"fastest_decay_stiffness_N_per_m", best.stiffness_N_per_m},
                     {"fastest_decay_damping_N_s_per_m", best.damping_N_s_per_m},
                     {"allowed_damping_N_s_per_m", figures.allowed.damping_N_s_per_m},
                     {"allowed_damping_Nm_s_per_rad", figures.allowed.damping_Nm_s_per_rad},
                     {"least_stiffness_share", figures.least_stiffness_share},
                     {"energy_J", figures.energy_J},
                     {"least_energy_J", figures.least_energy_J},
                     {"samples_made_passive", figures.samples_made_passive},
                     {"share_made_passive", figures.share_made_passive()},
                     {"muscle", MusclePart(bridge.muscle(i))},
                     {"first_cause", StatusNames(figures.first_cause)},
                     {"filter_samples", samples}});
  }
  report["peak_force_N"] = peak_N;
  report["samples_over_cap"] = over_limit;
  report["roles"] = roles;
  report["direct_ms"] = ToJson(bridge.echo_log().Summary(EchoLog::Chain::kDirect));
  report["t1_ms"] = ToJson(bridge.echo_log().Summary(EchoLog::Chain::kThroughPhysics));
  report["echoes_unknown"] = bridge.echo_log().num_unknown();
  report["echoes_not_kept"] = bridge.echo_log().num_not_kept();
  const SimulatedOperator& person = bridge.simulated_operator();
  json lines = json::array();
  for (const LineRecord& record : person.records()) {
    lines.push_back({{"step", person.script().steps[static_cast<std::size_t>(record.step)].name},
                     {"line", record.line},
                     {"seconds", static_cast<double>(record.end_ns - record.begin_ns) * 1e-9},
                     {"strokes", record.num_strokes},
                     {"outcome", Text(record.outcome)}});
  }
  report["operator"] = {{"is_simulated", true}, {"lines", lines}};
  return report;
}

core::Result<void> WriteLatencyTable(const EchoLog& log, const std::filesystem::path& file) {
  std::ofstream stream(file);
  stream << "chain,trace_id,origin_ns,echo_ns,stages\n";
  for (const EchoLog::Chain chain : {EchoLog::Chain::kDirect, EchoLog::Chain::kThroughPhysics}) {
    for (const EchoLog::Echo& echo : log.echoes(chain)) {
      stream << (chain == EchoLog::Chain::kDirect ? "direct," : "t1,") << echo.trace.id << ',' << echo.trace.origin_ns
             << ',' << echo.echo_ns;
      for (const core::Stamp& stamp : echo.trace.stamps)
        stream << ',' << static_cast<int>(stamp.stage) << ',' << stamp.offset_ns;
      stream << '\n';
    }
  }
  stream.flush();
  if (!stream) {
    return core::Fail(core::ErrorCode::kIo,
                      file.string() + ": cannot be written. Does the folder exist, and has the disk space left?");
  }
  return {};
}

}  // namespace device_bridge
