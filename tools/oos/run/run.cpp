#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "bus/log/merge_mcap.hpp"
#include "collision/resolution/choose_resolutions.hpp"
#include "lab/lab.hpp"
#include "nodes/device_bridge/devices/make_device.hpp"
#include "nodes/lockstep/lockstep.hpp"
#include "scene/load_scenario.hpp"
#include "tiles/seats.hpp"
#include "tools/oos/attach/attach.hpp"
#include "tools/oos/attach/places.hpp"
#include "tools/oos/check/check_scenario.hpp"
#include "tools/oos/run/latency/latency_table.hpp"
#include "tools/oos/run/report/film.hpp"
#include "tools/oos/run/report/report.hpp"
#include "tools/oos/run/report/report_page.hpp"
#include "tools/oos/run/session/session.hpp"
#include "tools/oos/run/verbs.hpp"
#include "tools/oos/verb/find_scenario.hpp"
#include "view/choices.hpp"
#include "vps/asset/cooked_object.hpp"

namespace oos {
namespace {

void Print(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
}

std::filesystem::path NewRunFolder(const std::string& scenario) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char stamp[32];
  std::strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", &local);
  return std::filesystem::absolute("out") / (scenario + "-" + stamp);
}

// "name=value" of --set.
core::Result<core::ParameterChange> ParseChange(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  char* end = nullptr;
  const std::string number = equals == std::string::npos ? "" : text.substr(equals + 1);
  const double value = std::strtod(number.c_str(), &end);
  if (equals == 0 || number.empty() || *end != '\0') {
    return core::Fail(core::ErrorCode::kInvalidInput, "--set needs PARAM=NUMBER, not '" + text + "'");
  }
  return core::ParameterChange{text.substr(0, equals), value};
}

struct Wanted {
  std::optional<std::uint64_t> seed;
  std::optional<double> duration_s;
  unsigned workers = 1;
  unsigned rays = 0;
  std::filesystem::path out;
  std::vector<core::ParameterChange> changes;
};

core::Result<Wanted> ReadWanted(const Arguments& arguments, const std::string& scenario) {
  Wanted wanted;
  const auto seed = arguments.count("--seed", 0, kLargestSeed), workers = arguments.count("--workers", 1, kMostWorkers);
  const auto rays = arguments.count("--rays", 1, tiles::kMostSeats);
  const auto duration = arguments.positive("--duration");
  if (!rays) return tl::unexpected(rays.error());
  if (!seed) return tl::unexpected(seed.error());
  if (!workers) return tl::unexpected(workers.error());
  if (!duration) return tl::unexpected(duration.error());
  if (const auto known = CheckNodeNames(arguments.texts("--without")); !known) return tl::unexpected(known.error());
  wanted.seed = *seed;
  wanted.duration_s = *duration;
  wanted.workers = static_cast<unsigned>(workers->value_or(1));
  wanted.rays = static_cast<unsigned>(rays->value_or(0));
  wanted.out = arguments.has("--out") ? std::filesystem::absolute(arguments.text("--out")) : NewRunFolder(scenario);
  for (const std::string& text : arguments.texts("--set")) {
    const auto change = ParseChange(text);
    if (!change) return core::Fail(change.error().code, change.error().detail);
    wanted.changes.push_back(*change);
  }
  return wanted;
}

nlohmann::json LockstepReport(const scene::Scenario& scenario, const lockstep::Outcome& outcome,
                              const std::filesystem::path& out) {
  RunFacts facts;
  facts.is_completed = outcome.is_completed;
  facts.why = outcome.why;
  facts.seed = outcome.seed;
  facts.seconds = outcome.simulated_s;
  facts.is_lockstep = true;
  nlohmann::json report = MergeReport(scenario, facts, out);
  report["steps"] = nlohmann::json::array();
  for (const lockstep::StepOutcome& step : outcome.steps) {
    nlohmann::json row = {{"name", step.name}, {"completed", step.is_completed}, {"seconds", step.seconds}};
    if (!step.is_completed) row["why"] = step.why;
    report["steps"].push_back(row);
  }
  report["peak_force_N"] = outcome.peak_force_N;
  // Without a real clock no cycle can be late.
  report["haptic"] = {{"cycles", outcome.ticks},
                      {"misses", nullptr},
                      {"contact_cycles", outcome.contact_cycles},
                      {"contact_misses", nullptr}};
  const auto add = [&report](const std::string& prefix, const lockstep::Times& times) {
    report["haptic"][prefix + "p50_us"] = times.p50_us;
    report["haptic"][prefix + "p99_us"] = times.p99_us;
    report["haptic"][prefix + "p9999_us"] = times.p9999_us;
    report["haptic"][prefix + "max_us"] = times.max_us;
  };
  add("", outcome.haptic);
  add("cpu_", outcome.haptic_cpu);
  add("contact_", outcome.contact);
  add("contact_cpu_", outcome.contact_cpu);
  report["impulse_balance"] = outcome.impulse_balance;
  report["stability"] = {{"least_stiffness_share", outcome.least_stiffness_share},
                         {"used_stiffness_share", outcome.used_stiffness_share},
                         {"least_energy_J", outcome.least_energy_J},
                         {"share_made_passive", outcome.share_made_passive}};
  char hash[20];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(outcome.hash));
  report["state_hash"] = hash;
  report["wall_seconds"] = outcome.wall_s;
  return report;
}

int RunInLockstep(const Arguments& arguments, const scene::Scenario& scenario, const Wanted& wanted,
                  nlohmann::json* report) {
  lockstep::Options options;
  if (wanted.seed) options.seed = *wanted.seed;
  options.duration_s = wanted.duration_s;
  options.workers = wanted.workers;
  options.cache = vps::DefaultCacheFolder();
  if (arguments.has("--trace")) options.trace = arguments.text("--trace");
  options.steps = arguments.text("--steps");
  const auto steps_from_s = arguments.number("--steps_from");
  if (!steps_from_s) return Complain("run", steps_from_s.error().detail, kBadUsage);
  options.steps_from_s = steps_from_s->value_or(0.0);
  options.parameters = wanted.changes;
  options.interrupted = &CatchInterrupt();
  options.say = Print;
  const auto outcome = lockstep::Run(scenario, options);
  if (!outcome) return Complain("run", outcome.error().detail, kBadUsage);
  std::error_code error;
  std::filesystem::create_directories(wanted.out, error);
  *report = LockstepReport(scenario, *outcome, wanted.out);
  if (!WriteReport(*report, wanted.out)) return Complain("run", "cannot write " + wanted.out.string(), kDoesNotHold);
  Print(Summarise(*report));
  std::printf(
      "%.1f s simulated in %.1f s (%.1f times real time), physics step p50 %.0f, p99 %.0f us, impulse balance %.2g\n",
      outcome->simulated_s, outcome->wall_s, outcome->simulated_s / outcome->wall_s, outcome->physics_p50_us,
      outcome->physics_p99_us, outcome->impulse_balance);
  std::printf("state hash %s\nreport in %s\n", (*report)["state_hash"].get<std::string>().c_str(), wanted.out.c_str());
  return outcome->is_completed ? kHolds : kDoesNotHold;
}

// Merges the nodes' recordings into one file and prints the result.
bool MergeRecordings(const std::filesystem::path& folder, const std::filesystem::path& to) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  const auto merge = bus::log::MergeMcap(files, to);
  if (!merge) {
    Complain("run", "the nodes' recordings in " + folder.string() + " stay apart: " + merge.error().detail,
             kDoesNotHold);
    return false;
  }
  std::printf("recording in %s: %llu messages of %zu files\n", to.c_str(),
              static_cast<unsigned long long>(merge->num_messages), files.size());
  for (const std::string& file : merge->incomplete) Print("its writer died: " + file);
  return true;
}

// Who had a window has somebody who looks at the page; a run that was ended by hand, or that lost a node, is over at
// once.
bool IsFilmed(const Arguments& arguments, const SessionOutcome& outcome, const std::atomic<int>& interrupted) {
  if (arguments.has("--film")) return true;
  const bool has_time = outcome.had_window && outcome.dead.empty() && interrupted.load() == 0;
  return has_time && !arguments.has("--no_film") && arguments.text("--method") != "both";
}

// A run is no worse for lack of a film, and its page is there without it.
void AddFilm(const nlohmann::json& report, const std::filesystem::path& folder, const std::atomic<int>& interrupted) {
  // Of a run that was interrupted and is filmed all the same, another Ctrl-C ends only what makes the film. Before the
  // line that says so: whoever reads it may interrupt at once.
  const std::atomic<int>* const ends_film = interrupted.load() == 0 ? &interrupted : nullptr;
  Print("making the film; this takes minutes where there is no graphics card, Ctrl-C leaves it out");
  if (const auto made = MakeFilm(folder, ends_film); !made) {
    Print(made.error().detail);
  } else if (WriteReportPage(report, folder)) {
    Print("film in " + FilmFile(folder).string() + ", and in the page");
  }
}

int RunProcesses(const Arguments& arguments, const scene::Scenario& scenario, const Wanted& wanted,
                 nlohmann::json* report) {
  if (!wanted.changes.empty()) {
    return Complain("run", "--set goes with --lockstep; for a running system use 'oos set NODE.PARAM VALUE'",
                    kBadUsage);
  }
  SessionOptions options;
  options.out = wanted.out;
  if (wanted.seed) options.seed = *wanted.seed;
  options.duration_s = wanted.duration_s;
  options.without = arguments.texts("--without");
  options.hand = arguments.text("--hand", options.hand);
  options.devices = arguments.texts("--device");
  options.is_colocated = arguments.has("--colocate");
  options.is_headless = arguments.has("--headless");
  options.is_encrypted = !arguments.has("--no_encryption");
  options.tcp_topics = arguments.text("--tcp_topics");
  options.multicast = arguments.text("--multicast");
  options.rt = arguments.text("--rt", "try");
  options.workers = wanted.workers;
  options.show = arguments.text("--show");
  options.rays = wanted.rays;
  options.program_folder = ProgramFolder();
  options.interrupted = &CatchInterrupt();
  options.say = Print;
  const std::string recording = arguments.text("--record");
  options.is_recorded = !recording.empty();
  if (arguments.has("--steps")) {
    options.steps = std::filesystem::absolute(arguments.text("--steps"));
    std::error_code error;
    std::filesystem::create_directories(options.steps, error);
    if (error) return Complain("run", options.steps.string() + ": " + error.message(), kBadUsage);
  }
  options.split_MB = arguments.text("--split_MB");
  options.split_s = arguments.text("--split_s");
  if (options.is_recorded && std::filesystem::exists(recording)) {
    return Complain("run", recording + ": is there already; name another file, or remove it", kBadUsage);
  }
  const auto outcome = RunSession(scenario, options);
  if (!outcome) return Complain("run", outcome.error().detail, kDoesNotHold);
  if (options.is_recorded && !MergeRecordings(RecordingFolder(options.out), recording)) return kDoesNotHold;
  if (const auto merged = MergeLatencyTables(options.out); !merged) Print(merged.error().detail);
  RunFacts facts;
  facts.is_completed = outcome->is_final;
  facts.why = outcome->why;
  facts.seed = outcome->seed;
  facts.seconds = outcome->seconds;
  facts.dead = outcome->dead;
  facts.missing_nodes = options.without;
  *report = MergeReport(scenario, facts, options.out);
  if (!WriteReport(*report, options.out)) return Complain("run", "cannot write " + options.out.string(), kDoesNotHold);
  Print(Summarise(*report));
  const bool is_filmed = IsFilmed(arguments, *outcome, *options.interrupted);
  Print("report in " + options.out.string() + "; the page is report.html" +
        (is_filmed ? "" : ", and 'oos report' adds a film to it"));
  if (is_filmed) AddFilm(*report, options.out, *options.interrupted);
  return outcome->is_final ? kHolds : kDoesNotHold;
}

int RunOnce(const Arguments& arguments, const scene::Scenario& scenario, const Wanted& wanted, nlohmann::json* report) {
  return arguments.has("--lockstep") ? RunInLockstep(arguments, scenario, wanted, report)
                                     : RunProcesses(arguments, scenario, wanted, report);
}

// The paper's method is the paper's coupling, too, unless another is wanted.
std::string CouplingOf(const Arguments& arguments, const scene::Scenario& scenario, const std::string& method) {
  const bool is_papers = arguments.has("--method") && method == "paper";
  return arguments.text("--coupling", is_papers ? "paper" : scenario.coupling.type);
}

// Resolutions that the scenario leaves open follow from the method. False: a mesh is gone, and that was said.
bool SetMethod(const std::string& method, scene::Scenario* scenario) {
  if (method == scenario->method) return true;
  scenario->method = method;
  const auto chosen = collision::ChooseResolutions(scenario);
  if (!chosen) Complain("run", scene::Format(chosen.error().front()), kBadUsage);
  return chosen.has_value();
}

// Runs each method in turn, each in a folder of its own, and writes a table of both.
int RunBothMethods(const Arguments& arguments, const scene::Scenario& scenario, const Wanted& wanted) {
  std::vector<nlohmann::json> reports;
  int worst = kHolds;
  for (const char* method : {"paper", "fast"}) {
    scene::Scenario one = scenario;
    if (!SetMethod(method, &one)) return kBadUsage;
    one.coupling.type = CouplingOf(arguments, scenario, method);
    Wanted its = wanted;
    its.out = wanted.out / one.method;
    Print("method " + one.method);
    nlohmann::json report;
    worst = std::max(worst, RunOnce(arguments, one, its, &report));
    if (report.is_null()) return worst;
    reports.push_back(std::move(report));
  }
  if (!WriteComparison(reports, wanted.out)) {
    return Complain("run", "cannot write " + wanted.out.string(), kDoesNotHold);
  }
  Print(CompareMethods(reports) + "both methods in " + (wanted.out / "report.md").string());
  return worst;
}

core::Result<void> CheckColocate(const Arguments& arguments) {
  if (!arguments.has("--colocate")) return {};
  const std::string nodes = arguments.text("--colocate");
  const auto without = arguments.texts("--without");
  std::string what;
  if (nodes != lab::kColocate) what = "is \"" + std::string(lab::kColocate) + "\", not '" + nodes + "'";
  if (arguments.has("--lockstep")) what = "goes with nodes on the bus; --lockstep has all nodes in one process";
  for (const char* node : lab::kColocatedNodes) {
    if (std::find(without.begin(), without.end(), node) != without.end()) what = "needs " + std::string(node);
  }
  if (what.empty()) return {};
  return core::Fail(core::ErrorCode::kInvalidInput, "--colocate " + what);
}

core::Result<void> ReadShow(const Arguments& arguments, const scene::Scenario& scenario) {
  if (!arguments.has("--show")) return {};
  if (arguments.has("--lockstep")) {
    return core::Fail(core::ErrorCode::kInvalidInput, "--show is for a viewer, and --lockstep has none");
  }
  std::vector<std::string> names;
  for (const scene::Object& object : scenario.objects) names.push_back(object.name);
  const auto choices = view::ReadChoices(arguments.text("--show"), names);
  if (!choices) return core::Fail(choices.error().code, "--show: " + choices.error().detail);
  return {};
}

int RunOnThisMachine(const Arguments& arguments) {
  const std::filesystem::path path = FindScenario(arguments.positional()[0]);
  const CheckOutcome check = CheckScenario(path);
  for (const std::string& line : check.problems) std::fprintf(stderr, "%s\n", line.c_str());
  if (!check.scenario || !check.problems.empty()) {
    return Complain("run", "the scenario is broken, nothing was started", kBadUsage);
  }
  scene::Scenario scenario = *check.scenario;
  const std::string method = arguments.text("--method", scenario.method);
  const bool is_both = method == "both";
  if (!is_both && !vps::MethodFromName(method)) {
    return Complain("run", "--method is paper, fast or both, not '" + method + "'", kBadUsage);
  }
  if (!is_both && !SetMethod(method, &scenario)) return kBadUsage;
  scenario.coupling.type = CouplingOf(arguments, scenario, method);
  if (scenario.coupling.type != "paper" && scenario.coupling.type != "god_object") {
    return Complain("run", "--coupling is paper or god_object, not '" + scenario.coupling.type + "'", kBadUsage);
  }
  const auto wanted = ReadWanted(arguments, scenario.name);
  if (!wanted) return Complain("run", wanted.error().detail, kBadUsage);
  if (const std::string rt = arguments.text("--rt", "try"); rt != "try" && rt != "off") {
    return Complain("run", "--rt is try or off, not '" + rt + "'", kBadUsage);
  }
  if (arguments.has("--trace") && (is_both || !arguments.has("--lockstep"))) {
    return Complain("run", "--trace goes with --lockstep and one method", kBadUsage);
  }
  if (arguments.has("--film") && (is_both || arguments.has("--lockstep"))) {
    return Complain("run", "--film shows a run of one method with its viewer, and --lockstep has no viewer", kBadUsage);
  }
  if (arguments.has("--film") && arguments.has("--no_film")) {
    return Complain("run", "it is --film or --no_film", kBadUsage);
  }
  if (arguments.has("--record") && (is_both || arguments.has("--lockstep"))) {
    return Complain("run", "--record goes with nodes on the bus and one method; --lockstep has --steps and --trace",
                    kBadUsage);
  }
  if (const std::string hand = arguments.text("--hand", "script"); hand != "script" && hand != "pointer") {
    return Complain("run", "--hand is script or pointer, not '" + hand + "'", kBadUsage);
  }
  if (arguments.has("--hand") && arguments.has("--lockstep")) {
    return Complain("run", "--hand goes with nodes on the bus; a person cannot follow --lockstep", kBadUsage);
  }
  if (const auto chosen = device_bridge::ChooseDevices(arguments.texts("--device"), &scenario); !chosen) {
    return Complain("run", chosen.error().detail, kBadUsage);
  }
  if (const auto choices = ReadShow(arguments, scenario); !choices) {
    return Complain("run", choices.error().detail, kBadUsage);
  }
  if (const auto fits = CheckColocate(arguments); !fits) return Complain("run", fits.error().detail, kBadUsage);
  if (arguments.has("--steps") && is_both) return Complain("run", "--steps goes with one method", kBadUsage);
  if (is_both) return RunBothMethods(arguments, scenario, *wanted);
  nlohmann::json report;
  return RunOnce(arguments, scenario, *wanted, &report);
}

}  // namespace

Verb RunVerb() {
  return {
      "run",
      "starts all nodes on this machine, waits for the procedure's end, writes a report",
      "SCENARIO",
      1,
      1,
      {{"--headless", "", "render pictures but show no window"},
       {"--seed", "N", "seed of the simulated operator; default: the scenario's"},
       {"--hand", "script|pointer",
        "who moves the hands of simulated arms: the scenario's script, or you, by mouse, keyboard, gamepad or "
        "SpaceMouse"},
       {"--device", "ROLE=TYPE:ADDRESS",
        "a device for a role in place of the scenario's, as right=udp:7460 (repeatable)"},
       {"--duration", "S", "time limit; default: the scenario's"},
       {"--out", "DIR", "folder for the report and the logs; default: out/<scenario>-<time>"},
       {"--method", "paper|fast|both", "collision method, or one run with each and a table; default: the scenario's"},
       {"--coupling", "paper|god_object",
        "how the hand follows the device; default: the scenario's, but paper with --method paper"},
       {"--rt", "try|off", "real-time priority for the 1 kHz loops; default: try"},
       {"--workers", "N", "threads of the collision computation; default: 1"},
       {"--show", "LIST", "what is shown over the scene at first, e.g. \"robot paths no_contacts\""},
       {"--rays", "N", "pictures are traced by N workers instead of OpenGL"},
       {"--without", "NODE", "leave a node out, e.g. visual_node (repeatable)"},
       {"--colocate", "'haptic physics'", "haptic_node and physics_node in one process, one step after the other"},
       {"--lockstep", "", "all nodes in one process on a virtual clock: deterministic, no pictures"},
       {"--film", "",
        "film the run into its page once it is over: minutes without a graphics card; default: after a run in a "
        "window"},
       {"--no_film", "", "leave the film out; Ctrl-C while it is made does so, too"},
       {"--record", "FILE.mcap", "record all messages of every node; the nodes' own files stay in DIR/recording"},
       {"--split_MB", "N", "with --record: nodes begin a new file at this size"},
       {"--split_s", "N", "with --record: nodes begin a new file at this age"},
       {"--trace", "FILE.csv", "with --lockstep: poses, forces and mechanisms every 10 ms"},
       {"--steps", "PATH", "record every step of the nodes for 'oos replay': a folder; with --lockstep a file, .mcap"},
       {"--steps_from", "S", "begin that recording at this time, with checkpoints and a new haptic_node"},
       {"--no_encryption", "", "no keys: anybody on the network can read and send messages"},
       {"--tcp_topics", "PATTERNS", "LATEST topics sent by ZeroMQ instead of UDP, e.g. 'physics/*,contacts/*'"},
       {"--multicast", "GROUP:PORT", "send LATEST once to a group, e.g. 239.255.74.50:7450; default: to each reader"},
       {"--set", "PARAM=VALUE", "with --lockstep: set a parameter at the first tick (repeatable)"}},
      RunOnThisMachine};
}

}  // namespace oos
