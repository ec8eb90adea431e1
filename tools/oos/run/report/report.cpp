#include "tools/oos/run/report/report.hpp"

#include <algorithm>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tools/oos/run/latency/hop_bounds.hpp"
#include "tools/oos/run/report/report_page.hpp"

namespace oos {
namespace {

using nlohmann::json;

// The report that a node wrote at its end; null if it is missing or unreadable (the node was killed or left out).
json ReadNodeFile(const std::filesystem::path& folder, const std::string& node) {
  std::ifstream file(folder / (node + ".json"));
  if (!file) return nullptr;
  json content = json::parse(file, nullptr, false);
  return content.is_discarded() ? json(nullptr) : content;
}

json Get(const json& object, const std::string& key) {
  return object.is_object() && object.contains(key) ? object.at(key) : json(nullptr);
}

json Sum(const std::vector<json>& nodes, const std::string& key) {
  std::uint64_t sum = 0;
  bool is_any = false;
  for (const json& node : nodes) {
    const json value = Get(Get(node, "bus"), key);
    if (!value.is_number()) continue;
    sum += value.get<std::uint64_t>();
    is_any = true;
  }
  return is_any ? json(sum) : json(nullptr);
}

json HapticPart(const json& haptic) {
  json part = json::object();
  for (const char* prefix : {"", "contact_"}) {
    for (const char* key : {"cycles", "misses", "p50_us", "p99_us", "p9999_us", "max_us", "cpu_p50_us", "cpu_p99_us",
                            "cpu_p9999_us", "cpu_max_us"}) {
      part[std::string(prefix) + key] = Get(haptic, std::string(prefix) + key);
    }
  }
  part["stolen_share"] = Get(haptic, "stolen_share");
  part["is_realtime"] = Get(haptic, "is_realtime");
  return part;
}

std::string Text(const json& value) {
  if (value.is_null()) return "-";
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_float()) {
    std::ostringstream out;
    out.precision(4);
    out << value.get<double>();
    return out.str();
  }
  return value.dump();
}

void WriteSteps(const json& report, std::ostream& out) {
  out << "| step | completed | s | why |\n|---|---|---|---|\n";
  for (const json& step : report.at("steps")) {
    out << "| " << Text(Get(step, "name")) << " | " << Text(Get(step, "completed")) << " | "
        << Text(Get(step, "seconds")) << " | " << (Get(step, "why").is_null() ? "" : Text(Get(step, "why"))) << " |\n";
  }
}

void WriteLatencies(const json& report, std::ostream& out) {
  out << "| | mean | +- by the clocks | p50 | p99 | max | n |\n|---|---|---|---|---|---|---|\n";
  for (const char* chain : {"direct_ms", "t1_ms", "t2_state_ms", "t2_image_ms"}) {
    const json figures = Get(report, chain);
    out << "| " << chain;
    for (const char* key : {"mean", "clock_bound", "p50", "p99", "max", "n"}) out << " | " << Text(Get(figures, key));
    out << " |\n";
  }
}

void WriteTactiles(const json& report, std::ostream& out) {
  const json devices = Get(report, "tactile");
  if (devices.empty()) return;
  out << "\n## Tactile devices\n\n| | device | status | touching, s | greatest level | frames | errors |\n"
      << "|---|---|---|---|---|---|---|\n";
  for (const json& device : devices) {
    for (const char* key : {"name", "device", "status", "touching_s", "greatest_level", "frames", "errors"}) {
      out << "| " << Text(Get(device, key)) << " ";
    }
    out << "|\n";
  }
}

// The worst of all hands.
json StabilityPart(const json& bridge) {
  const json roles = Get(bridge, "roles");
  json part = json::object();
  const auto take = [&](const char* key, const auto& is_worse) {
    json worst;
    for (const json& role : roles) {
      const json value = Get(role, key);
      if (value.is_number() && (worst.is_null() || is_worse(value.get<double>(), worst.get<double>()))) worst = value;
    }
    part[key] = worst;
  };
  take("least_stiffness_share", std::less<>());
  take("least_energy_J", std::less<>());
  take("share_made_passive", std::greater<>());
  take("loop_delay_ms", std::greater<>());
  take("loop_jitter_ms", std::greater<>());
  return part;
}

void WriteMarkdown(const json& report, const std::filesystem::path& folder, std::ostream& out) {
  out << "# " << Text(Get(report, "scenario")) << "\n\n"
      << (report.at("completed").get<bool>() ? "Completed." : "Not completed: " + Text(Get(report, "why")) + ".")
      << " Seed " << Text(Get(report, "seed")) << ", method " << Text(Get(report, "method")) << ", "
      << Text(Get(report, "seconds")) << " s.\n\n";
  WriteSteps(report, out);
  out << "\nPeak force on the hand " << Text(Get(report, "peak_force_N"))
      << " N. Impulses that were lost, doubled or made up, of "
      << "all that were applied (impulse balance): " << Text(Get(report, "impulse_balance"))
      << ". Stiffness that the delay of the force loop allows, of the coupling's: at least "
      << Text(Get(Get(report, "stability"), "least_stiffness_share")) << "; used: at least "
      << Text(Get(Get(report, "stability"), "used_stiffness_share")) << ". Least energy of the hand "
      << Text(Get(Get(report, "stability"), "least_energy_J")) << " J; the passivity controller acted in "
      << Text(Get(Get(report, "stability"), "share_made_passive"))
      << " of the writes to the device.\n\n## Latency, ms\n\n";
  WriteLatencies(report, out);
  WriteTactiles(report, out);
  out << "\n## Haptic cycles\n\n| | all | in contact |\n|---|---|---|\n";
  const json& haptic = report.at("haptic");
  for (const char* key :
       {"cycles", "misses", "p50_us", "p99_us", "max_us", "cpu_p50_us", "cpu_p99_us", "cpu_p9999_us", "cpu_max_us"}) {
    out << "| " << key << " | " << Text(Get(haptic, key)) << " | " << Text(Get(haptic, std::string("contact_") + key))
        << " |\n";
  }
  out << "\nShare of all processors' time that the host of a virtual machine took away: "
      << Text(Get(haptic, "stolen_share")) << ".\n\nBus: " << Text(Get(report.at("bus"), "sent")) << " sent, "
      << Text(Get(report.at("bus"), "received")) << " received, " << Text(Get(report.at("bus"), "dropped"))
      << " dropped.\n\nSimulated: ";
  for (std::size_t i = 0; i < report.at("simulated").size(); ++i) {
    out << (i == 0 ? "" : "; ") << Text(report.at("simulated")[i]);
  }
  out << ".\n";
  std::vector<std::filesystem::path> pictures;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".png") pictures.push_back(entry.path().filename());
  }
  for (const auto& entry : std::filesystem::directory_iterator(folder / "frames", error)) {
    if (entry.path().extension() == ".png") pictures.push_back("frames" / entry.path().filename());
  }
  std::sort(pictures.begin(), pictures.end());
  if (!pictures.empty()) out << "\n## Pictures\n\n";
  for (const std::filesystem::path& picture : pictures) {
    out << "![" << picture.stem().string() << "](" << picture.string() << ")\n";
  }
}

}  // namespace

json MergeReport(const scene::Scenario& scenario, const RunFacts& facts, const std::filesystem::path& folder) {
  const json bridge = ReadNodeFile(folder, "device_bridge");
  const json haptic = ReadNodeFile(folder, "haptic_node");
  const json physics = ReadNodeFile(folder, "physics_node");
  const json logic = ReadNodeFile(folder, "logic_node");
  const json visual = ReadNodeFile(folder, "visual_node");

  json report;
  report["scenario"] = scenario.name;
  report["method"] = scenario.method;
  report["coupling"] = scenario.coupling.type;
  report["seed"] = facts.seed;
  report["completed"] = facts.is_completed;
  if (!facts.is_completed) report["why"] = facts.why;
  report["seconds"] = facts.seconds;
  report["steps"] = Get(logic, "steps").is_array() ? Get(logic, "steps") : json::array();
  report["peak_force_N"] = Get(bridge, "peak_force_N");
  report["haptic"] = HapticPart(haptic);
  for (const char* chain : {"direct_ms", "t1_ms"}) report[chain] = Get(bridge, chain);
  // By the clocks of device_bridge's and of visual_node's machine.
  const HopBounds bounds = HopBounds::Read(folder);
  const auto to_physics_ns = bounds.Between(core::Stage::kHapticSend, core::Stage::kPhysicsReceive);
  const auto to_visual_ns = bounds.Between(core::Stage::kPhysicsSend, core::Stage::kVisualReceive);
  const auto to_haptic_ns = bounds.Between(core::Stage::kDeviceSend, core::Stage::kHapticReceive);
  for (const char* chain : {"t2_state_ms", "t2_image_ms"}) {
    if (!to_physics_ns || !to_visual_ns || !to_haptic_ns) continue;  // clocks that were not compared
    report[chain] = Get(visual, chain);
    if (!report[chain].is_object() || bounds.is_one_machine()) continue;
    report[chain]["clock_bound"] = 1e-6 * static_cast<double>(*to_haptic_ns + *to_physics_ns + *to_visual_ns);
  }
  const std::vector<json> nodes = {bridge, haptic, physics, logic, visual};
  report["bus"] = {
      {"sent", Sum(nodes, "sent")}, {"received", Sum(nodes, "received")}, {"dropped", Sum(nodes, "dropped")}};
  report["impulse_balance"] = Get(physics, "impulse_balance");
  report["stability"] = StabilityPart(bridge);
  report["stability"]["used_stiffness_share"] = Get(haptic, "least_stiffness_share");
  if (!visual.is_null()) {
    for (const char* key : {"fps", "render_scale", "cpu_ms_per_frame"}) report["pictures"][key] = Get(visual, key);
    report["pictures"]["draw_p50_ms"] = Get(Get(visual, "draw_ms"), "p50");
  }
  report["nodes_that_died"] = facts.dead;
  report["nodes_left_out"] = facts.missing_nodes;
  report["simulated"] = json::array({"hand devices (mass-damper arms with a scripted operator)"});
  for (const json& role : Get(bridge, "roles")) {
    if (!Get(role, "muscle").is_null()) {
      report["simulated"].push_back("muscle signals of " + Text(Get(role, "role")) + " (a generator)");
    }
  }
  report["tactile"] = Get(bridge, "tactile");
  for (const json& device : report["tactile"]) {
    if (Get(device, "is_simulated") == true) {
      report["simulated"].push_back(Text(Get(device, "name")) + " (a " + Text(Get(device, "device")) + " in memory)");
    }
  }
  if (facts.is_lockstep) report["simulated"].push_back("time (virtual clock, no bus, no pictures)");
  if (!Get(visual, "gl_renderer").is_null()) {
    report["simulated"].push_back("drawn by " + Text(Get(visual, "gl_renderer")));
  }
  return report;
}

bool WriteReport(const json& report, const std::filesystem::path& folder) {
  std::ofstream machine(folder / "report.json");
  machine << report.dump(2) << "\n";
  std::ofstream people(folder / "report.md");
  WriteMarkdown(report, folder, people);
  return machine.good() && people.good() && WriteReportPage(report, folder);
}

std::string Summarise(const json& report) {
  std::ostringstream out;
  for (const json& step : report.at("steps")) {
    const json completed = Get(step, "completed");
    out << (completed.is_boolean() && completed.get<bool>() ? "  done    " : "  missed  ") << Text(Get(step, "name"))
        << "  " << Text(Get(step, "seconds")) << " s";
    if (!Get(step, "why").is_null()) out << "  " << Text(Get(step, "why"));
    out << "\n";
  }
  out << "  peak force " << Text(Get(report, "peak_force_N")) << " N, haptic step p50 "
      << Text(Get(report.at("haptic"), "contact_p50_us")) << " us in contact, "
      << Text(Get(report.at("haptic"), "misses")) << " of " << Text(Get(report.at("haptic"), "cycles"))
      << " cycles late\n";
  for (const char* chain : {"direct_ms", "t1_ms", "t2_state_ms", "t2_image_ms"}) {
    const json figures = Get(report, chain);
    if (!figures.is_object()) continue;
    const json bound = Get(figures, "clock_bound");
    out << "  " << chain << " mean " << Text(Get(figures, "mean"))
        << (bound.is_null() ? "" : " +- " + Text(bound) + " by the clocks") << ", p99 " << Text(Get(figures, "p99"))
        << ", n " << Text(Get(figures, "n")) << "\n";
  }
  out << (report.at("completed").get<bool>() ? "completed" : "NOT completed: " + Text(Get(report, "why")));
  return out.str();
}

std::string CompareMethods(const std::vector<json>& reports) {
  struct Row {
    const char* title;
    const char* part;  // of the report; empty: the report itself
    const char* key;
  };
  constexpr Row kRows[] = {{"completed", "", "completed"},
                           {"seconds", "", "seconds"},
                           {"haptic step in contact, processor time, p50, us", "haptic", "contact_cpu_p50_us"},
                           {"p99", "haptic", "contact_cpu_p99_us"},
                           {"p99.99", "haptic", "contact_cpu_p9999_us"},
                           {"cycles in contact", "haptic", "contact_cycles"},
                           {"all haptic steps, processor time, p50, us", "haptic", "cpu_p50_us"},
                           {"p99", "haptic", "cpu_p99_us"},
                           {"cycles", "haptic", "cycles"},
                           {"of these late", "haptic", "misses"},
                           {"t1, mean, ms", "t1_ms", "mean"},
                           {"p99", "t1_ms", "p99"},
                           {"peak force on the hand, N", "", "peak_force_N"}};
  std::ostringstream out;
  out << "| " << Text(Get(reports.front(), "scenario"));
  for (const json& report : reports) out << " | " << Text(Get(report, "method"));
  out << " |\n|---";
  for (std::size_t i = 0; i < reports.size(); ++i) out << "|---";
  out << "|\n";
  for (const Row& row : kRows) {
    out << "| " << row.title;
    for (const json& report : reports) {
      out << " | " << Text(Get(*row.part == '\0' ? report : Get(report, row.part), row.key));
    }
    out << " |\n";
  }
  return out.str();
}

bool WriteComparison(const std::vector<json>& reports, const std::filesystem::path& folder) {
  json by_method;
  for (const json& report : reports) by_method[Text(Get(report, "method"))] = report;
  std::ofstream machine(folder / "report.json");
  machine << by_method.dump(2) << "\n";
  std::ofstream people(folder / "report.md");
  people << "# " << Text(Get(reports.front(), "scenario")) << ", one run with each method\n\n"
         << CompareMethods(reports) << "\nThe whole reports:";
  for (const json& report : reports) {
    const std::string method = Text(Get(report, "method"));
    people << " [" << method << "](" << method << "/report.md)";
  }
  people << ".\n";
  return machine.good() && people.good();
}

}  // namespace oos
