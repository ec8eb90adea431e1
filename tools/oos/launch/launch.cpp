#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/clock.hpp"
#include "core/hash.hpp"
#include "lab/load_lab.hpp"
#include "lab/plan.hpp"
#include "lab/unit_files.hpp"
#include "scene/limit_reached.hpp"
#include "tools/oos/attach/attach.hpp"
#include "tools/oos/attach/lease.hpp"
#include "tools/oos/attach/places.hpp"
#include "tools/oos/check/check_scenario.hpp"
#include "tools/oos/launch/clock_series.hpp"
#include "tools/oos/launch/comeback.hpp"
#include "tools/oos/launch/keys.hpp"
#include "tools/oos/launch/preflight.hpp"
#include "tools/oos/launch/verbs.hpp"
#include "tools/oos/launch/watch.hpp"
#include "tools/oos/run/latency/latency_table.hpp"
#include "tools/oos/run/report/report.hpp"
#include "tools/oos/verb/find_scenario.hpp"
#include "vps/asset/method.hpp"

namespace oos {
namespace {

constexpr double kReadyPatience_s = 240.0;  // cooking a big scene for the first time takes minutes
constexpr double kClockPeriod_s = 5.0;
constexpr double kTakenOverPeriod_s = 0.3;
constexpr int kPoll_ms = 100;

void Print(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
}

double Since_s(std::int64_t begin_ns) {
  return static_cast<double>(core::MonotonicNow_ns() - begin_ns) * 1e-9;
}

std::string Stamp(const char* format) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char text[32];
  std::strftime(text, sizeof text, format, &local);
  return text;
}

std::string ReadLine(const char* file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

struct Wanted {
  lab::PlanOptions plan;
  std::optional<double> duration_s;
  std::filesystem::path out;
  std::filesystem::path record;  // empty: not recorded
  std::filesystem::path steps;   // likewise
};

// One launch. Its destructor leaves no process of it on any host.
class Launch {
 public:
  Launch(const scene::Scenario& scenario, const lab::Lab& lab, Wanted wanted)
      : scenario_(scenario),
        lab_(lab),
        wanted_(std::move(wanted)),
        interrupted_(CatchInterrupt()),
        remotes_(UsedHosts()) {
    preflight_.programs = ProgramFolder();
    preflight_.without = wanted_.plan.without;
    preflight_.viewer_programs = lab_.ProgramsOfViewersOn("");
    if (lab_.traces_rays()) {
      preflight_.viewer_programs.insert(preflight_.viewer_programs.end(),
                                        {lab::kRayViewerProgram, lab::kRayWorkerProgram});
    }
    preflight_.say = Print;
  }
  Launch(const Launch&) = delete;
  Launch& operator=(const Launch&) = delete;
  ~Launch() {
    if (has_leases_) ReleaseLeases(wanted_.plan.run, roots_, &remotes_);
  }

  int Run() {
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    if (const auto ready = Prepare(); !ready) {
      std::fprintf(stderr, "%s\n", ready.error().detail.c_str());
      return Complain("launch", "nothing was started", kDoesNotHold);
    }
    char text[64];
    std::snprintf(text, sizeof text, "preflight took %.1f s; starting", Since_s(begin_ns));
    Print(text);
    const auto started = Start();
    if (!started) why_ = started.error().detail;
    if (why_.empty()) WaitUntilReady();
    if (why_.empty()) Watch();
    return Finish();
  }

 private:
  std::vector<lab::Host> UsedHosts() const {
    std::vector<lab::Host> used;
    for (const lab::Host& host : lab_.hosts) {
      const bool has_node = std::any_of(lab_.placements.begin(), lab_.placements.end(),
                                        [&](const lab::Placement& p) { return p.host == host.name && !IsOut(p.node); });
      const bool has_workers =
          !IsOut("visual_node") && std::any_of(lab_.ray_workers.begin(), lab_.ray_workers.end(),
                                               [&](const lab::RayWorkers& w) { return w.host == host.name; });
      const bool has_viewer = !lab_.ViewersOn(host.name).empty();
      if (has_node || has_workers || has_viewer || host.name == lab_.registry_host) used.push_back(host);
    }
    return used;
  }
  [[nodiscard]] bool IsOut(const std::string& node) const {
    const auto& without = wanted_.plan.without;
    return std::find(without.begin(), without.end(), node) != without.end();
  }
  [[nodiscard]] core::Result<void> Interrupted() const {
    if (interrupted_.load() == 0) return {};
    return core::Fail(core::ErrorCode::kTimeout, "interrupted");
  }

  core::Result<void> Prepare() {
    Print("reaching " + std::to_string(remotes_.hosts().size()) + " hosts");
    if (const auto done = remotes_.Connect(); !done) return done;
    if (const auto free = CheckFree(&remotes_); !free)
      return free;  // otherwise the only complaint would be that its ports are in use
    auto facts = AskHosts(lab_, &remotes_);
    if (!facts) return tl::unexpected(facts.error());
    facts_ = std::move(*facts);
    for (const lab::Host& host : remotes_.hosts()) {
      roots_.push_back(facts_.at(host.name).root);
      if (IsPlain(roots_.back())) continue;
      return core::Fail(core::ErrorCode::kInvalidInput,
                        "host " + host.name + ": its run folder is " + roots_.back() +
                            ", and that becomes part of commands; give it a run_folder of letters, digits and /._+@-");
    }
    if (const auto done = TakeLeases(MakeLease(), roots_, &remotes_); !done) return done;
    has_leases_ = true;
    if (const auto done = Interrupted(); !done) return done;
    if (const auto done = Push(lab_, scenario_, preflight_, &remotes_, &facts_); !done) return done;
    if (const auto done = Interrupted(); !done) return done;
    if (const auto done = CheckHosts(lab_, preflight_, &remotes_, facts_); !done) return done;
    for (const lab::Host& host : lab_.hosts) facts_.try_emplace(host.name);
    plan_ = lab::MakePlan(lab_, facts_, wanted_.plan);
    return Interrupted();
  }

  Lease MakeLease() const {
    Lease lease;
    lease.values = {{"run", wanted_.plan.run},
                    {"who", UserAtHost()},
                    {"pid", std::to_string(getpid())},
                    {"boot", ReadLine("/proc/sys/kernel/random/boot_id")},
                    {"scenario", scenario_.file.string()},
                    {"lab", lab_.file.string()},
                    {"out", wanted_.out.string()},
                    {"registry", lab::RegistryEndpoint(lab_, facts_)},
                    {"session", std::to_string(wanted_.plan.session)},
                    {"since", Stamp("%Y-%m-%d %H:%M:%S")}};
    return lease;
  }

  core::Result<void> Start() {
    start_ns_ = core::MonotonicNow_ns();
    is_started_ = true;
    std::vector<std::string> write(remotes_.hosts().size()), start(remotes_.hosts().size());
    std::vector<std::vector<std::string>> units(remotes_.hosts().size());
    std::vector<Comebacks::Host> hosts;
    for (std::size_t i = 0; i < remotes_.hosts().size(); ++i) {
      const lab::HostPlan& plan = plan_.hosts[i];
      const lab::UnitFiles files = lab::FilesFor(plan);
      write[i] = "umask 077\nmkdir -p " + plan.run_folder + "/steps && cd " + plan.run_folder + " || exit 1\n";
      for (const auto& [name, text] : files.files) WriteFile(name, text, &write[i]);
      WriteFile("stop.sh", files.stop, &write[i]);
      WriteFile("status.sh", files.status, &write[i]);
      const std::string run_name = "export OOS_RUN=" + plan_.run + "\n";
      start[i] = run_name + files.start;
      for (const lab::Unit& unit : plan.units) {
        units[i].push_back(unit.name);
        for (const std::string& node : unit.nodes) nodes_of_[unit.name].insert(node);
        expected_.insert(unit.nodes.begin(), unit.nodes.end());
      }
      if (plan.host.supervisor == lab::SupervisorKind::kSupervisor) {
        units[i].push_back("supervisord-" + plan.host.name);
      }
      hosts.push_back({roots_[i], run_name + files.resume, units[i]});
    }
    if (const auto done = DoAll(write, "cannot write the run folder"); !done) return done;
    if (const auto done = PushKeys(); !done) return done;
    if (const auto done = streams_.Open(plan_.run, roots_, units, &remotes_); !done) return done;
    if (const auto noted = NoteSession(); !noted) return noted;
    comebacks_.emplace(plan_.run, hosts, &remotes_, &streams_);
    return DoAll(start, "the supervisor does not start");
  }

  core::Result<void> PushKeys() {
    if (const auto made = keys_.Make(wanted_.out / "keys"); !made) return made;
    std::vector<std::string> scripts;
    for (const lab::HostPlan& plan : plan_.hosts) {
      auto script = keys_.ScriptFor(plan);
      if (!script) return tl::unexpected(script.error());
      scripts.push_back(std::move(*script));
    }
    return DoAll(scripts, "cannot write the keys");
  }

  static void WriteFile(const std::string& name, const std::string& text, std::string* script) {
    *script += "cat >" + name + " <<'END_OF_FILE'\n" + text + (text.empty() || text.back() != '\n' ? "\n" : "") +
               "END_OF_FILE\n";
  }

  core::Result<void> DoAll(const std::vector<std::string>& scripts, const std::string& complaint) {
    const std::vector<Answer> answers = remotes_.RunAll(scripts);
    for (std::size_t i = 0; i < answers.size(); ++i) {
      if (answers[i].is_good()) continue;
      return core::Fail(core::ErrorCode::kIo,
                        "host " + remotes_.hosts()[i].name + ": " + complaint + ": " + answers[i].err + answers[i].out);
    }
    return {};
  }

  // So that `oos topic`, `top` and `set` find the session from here.
  core::Result<void> NoteSession() {
    const nlohmann::json note = {{"registry", plan_.registry},
                                 {"session", std::to_string(plan_.session)},
                                 {"pid", getpid()},
                                 {"out", wanted_.out.string()},
                                 {"keys", keys_.directory().string()},
                                 {"scenario", scenario_.file.string()}};
    return WriteSessionNote(note.dump() + "\n");
  }

  // Processes new lines of the logs; sets `why_` if the run cannot go on.
  void Listen() {
    streams_.Poll(kPoll_ms, [this](const std::string& host, const std::string& unit, const std::string& line) {
      if (unit == "registry") {
        const std::string text = story_.Take(line);
        if (!text.empty()) Say(host, "bus", text);
      } else if (unit.rfind("supervisord-", 0) == 0) {
        TakeSupervisor(host, line);
      } else if (const lab::Viewer* const page = FindPage(unit); page != nullptr && !PageAddress(line).empty()) {
        const std::string address = PageAddress(line);
        const std::string port = std::to_string(page->port);
        Say(host, unit,
            address + " (on another machine first: ssh -L " + port + ":127.0.0.1:" + port + " " +
                lab_.FindHost(host)->address + ")");
      } else {
        Say(host, unit, line);
      }
    });
    if (!story_.refusal().empty() && why_.empty()) why_ = story_.refusal();
    if (interrupted_.load() != 0 && why_.empty()) why_ = "interrupted";
    const std::string gone = comebacks_->Poll([this](const std::string& host, const std::string& text) {
      Print("host " + host + " " + text);
      if (text != "is silent") clocks_.clear();  // read again
    });
    if (why_.empty()) why_ = gone;
    is_taken_over_ = is_taken_over_ || comebacks_->was_stopped();
    if (story_.is_down() && why_.empty()) AskWhetherTakenOver();
    ReadClocks();
  }

  // The registry has ended. Either a supervisor restarts it, or the run is being stopped from another machine: then the
  // lease says so (MarkStopping), until the run's folder is removed.
  void AskWhetherTakenOver() {
    if (Since_s(taken_over_asked_ns_) < kTakenOverPeriod_s) return;
    taken_over_asked_ns_ = core::MonotonicNow_ns();
    for (std::size_t i = 0; i < remotes_.hosts().size(); ++i) {
      if (remotes_.hosts()[i].name != lab_.registry_host) continue;
      const Answer answer = remotes_.Run(i, "cat " + roots_[i] + "/lease 2>/dev/null\n[ -d " + roots_[i] + "/runs/" +
                                                plan_.run + " ] || echo gone=1\n");
      if (!answer.is_good() || (answer.value("stopping").empty() && answer.value("gone") != "1")) return;
      is_taken_over_ = true;
      why_ = "stopped from elsewhere" +
             (answer.value("stopping").empty() ? std::string() : " by " + answer.value("stopping"));
    }
  }

  // What the page's bridge says when it is there; else empty.
  static std::string PageAddress(const std::string& line) {
    if (line.rfind("{\"page\":", 0) != 0) return {};
    const nlohmann::json said = nlohmann::json::parse(line, nullptr, false);
    const bool is_address = said.is_object() && said.contains("page") && said["page"].is_string();
    return is_address ? said["page"].get<std::string>() : std::string();
  }
  [[nodiscard]] const lab::Viewer* FindPage(const std::string& unit) const {
    const auto found = std::find_if(lab_.viewers.begin(), lab_.viewers.end(), [&](const lab::Viewer& viewer) {
      return viewer.renderer == lab::Renderer::kPage && unit == "visual_node-" + viewer.name;
    });
    return found != lab_.viewers.end() ? &*found : nullptr;
  }

  void Say(const std::string& host, const std::string& unit, const std::string& text) const {
    char time[32];
    std::snprintf(time, sizeof time, "%7.2f s  ", Since_s(start_ns_));
    Print(time + ("[" + host + "] ") + unit + ": " + text);
  }

  // "... INFO exited: physics_node (terminated by SIGKILL; not expected)", "... gave up: NAME entered FATAL state ..."
  void TakeSupervisor(const std::string& host, const std::string& line) {
    if (is_stopping_) return;
    for (const char* word : {"exited: ", "gave up: ", "spawnerr: "}) {
      const std::size_t at = line.find(word);
      if (at == std::string::npos) continue;
      const std::string text = line.substr(at);
      Say(host, "supervisor", text);
      const std::string rest = text.substr(std::string(word).size());
      const std::string unit = rest.substr(0, rest.find(' '));
      const auto nodes = nodes_of_.find(unit);
      if (text.find("; not expected") != std::string::npos && nodes != nodes_of_.end()) {
        dead_.insert(nodes->second.begin(), nodes->second.end());
      }
      if (std::string(word) == "gave up: ") TakeGivenUp(host, unit, text);
    }
  }

  // visual_node, and those of the lab's views and walls.
  static bool IsViewer(const std::string& node) { return node.rfind("visual_node", 0) == 0; }

  // The procedure can go on without pictures and without a recording.
  void TakeGivenUp(const std::string& host, const std::string& unit, const std::string& text) {
    if (IsViewer(unit) || unit == "display") {
      if (std::erase_if(expected_, [&](const std::string& node) {
            return unit == "display" ? IsViewer(node) : node == unit;
          }) != 0) {
        Print("host " + host + " shows no picture: see " + unit + ".log; the run goes on without");
      }
    } else if (unit != "recorder" && why_.empty()) {
      why_ = "host " + host + " " + text;
    }
  }

  void OpenClockFile() {
    if (clock_file_.is_open()) return;
    std::error_code error;
    std::filesystem::create_directories(wanted_.out, error);
    clock_file_.open(wanted_.out / "clocks.csv");
    clock_file_ << "time_ns,host,offset_ns,bound_ns\n";
  }

  void ReadClocks() {
    if (clocks_.empty()) {
      for (std::size_t i = 0; i < remotes_.hosts().size(); ++i) {
        auto series = ClockSeries::Open(&remotes_, i, facts_.at(remotes_.hosts()[i].name).programs + "/oos");
        clocks_.push_back(series ? std::make_unique<ClockSeries>(std::move(*series)) : nullptr);
      }
      OpenClockFile();
    }
    if (Since_s(clocks_read_ns_) < kClockPeriod_s) return;
    clocks_read_ns_ = core::MonotonicNow_ns();
    for (std::size_t i = 0; i < clocks_.size(); ++i) {
      const auto reading = clocks_[i] ? clocks_[i]->Read(5, 100) : std::nullopt;
      if (!reading) continue;
      clock_file_ << reading->time_ns << "," << remotes_.hosts()[i].name << "," << reading->offset_ns << ","
                  << reading->bound_ns << "\n";
    }
  }

  void WaitUntilReady() {
    const auto are_all_ready = [this] {
      return std::all_of(expected_.begin(), expected_.end(), [this](const std::string& node) {
        // The procedure begins when all the nodes that it needs are ready; it needs no viewer.
        return story_.ready().count(node) != 0 || (story_.runs() && !IsViewer(node));
      });
    };
    while (why_.empty() && !are_all_ready() && !story_.is_final() && !story_.is_failed()) {
      Listen();
      if (Since_s(start_ns_) < kReadyPatience_s) continue;
      why_ = "not ready in time:";
      for (const std::string& name : expected_) why_ += story_.ready().count(name) == 0 ? " " + name : "";
    }
    if (!why_.empty()) return;
    char text[96];
    std::snprintf(text, sizeof text, "all %zu nodes are ready, %.2f s after the start", expected_.size(),
                  Since_s(start_ns_));
    Print(text);
    ready_ns_ = core::MonotonicNow_ns();
  }

  void Watch() {
    const double limit_s = wanted_.duration_s.value_or(scenario_.duration_limit_s);
    while (why_.empty() && !story_.is_final() && !story_.is_failed()) {
      Listen();
      if (Since_s(ready_ns_) > limit_s && why_.empty()) why_ = scene::LimitReached(limit_s, story_.step());
    }
    seconds_ = Since_s(ready_ns_);
    if (story_.is_failed()) why_ = story_.why().empty() ? "failed in step " + story_.step() : story_.why();
    is_final_ = why_.empty() && story_.is_final();
  }

  // The one who stopped the run collects its files.
  int LeaveToOthers() {
    clocks_.clear();
    streams_.Close();
    std::error_code error;
    std::filesystem::remove(SessionFile(), error);
    has_leases_ = false;
    Print("what the run left is collected there");
    return kDoesNotHold;
  }

  int Finish() {
    if (!why_.empty()) Print("ends: " + why_);
    if (is_taken_over_) return LeaveToOthers();
    Print("stopping");
    is_stopping_ = true;
    clocks_.clear();
    const std::vector<std::string> left = StopRun(plan_.run, roots_, &remotes_);
    streams_.Close();
    std::error_code error;
    std::filesystem::remove(SessionFile(), error);
    for (const std::string& line : left) Print("left over: " + line);
    if (left.empty()) Print("no process of the run is left on " + std::to_string(roots_.size()) + " hosts");
    const auto collected = Collect(plan_.run, roots_, wanted_.out, &remotes_);
    if (!collected) Print(collected.error().detail);
    MoveRecordings(wanted_.out, wanted_.record);
    MoveRecordings(wanted_.out / "steps", wanted_.steps);
    std::filesystem::remove(wanted_.out / "steps", error);  // when it is empty
    const bool is_reported = Report();
    return is_final_ && left.empty() && collected && is_reported ? kHolds : kDoesNotHold;
  }

  // Moves the recordings to the requested places; what cannot be moved stays.
  static void MoveRecordings(const std::filesystem::path& from, const std::filesystem::path& to) {
    if (to.empty() || to == from) return;
    std::error_code error;
    std::filesystem::create_directories(to, error);
    for (const auto& entry : std::filesystem::directory_iterator(from, error)) {
      if (entry.path().extension() != ".mcap") continue;
      std::filesystem::copy_file(entry.path(), to / entry.path().filename(),
                                 std::filesystem::copy_options::overwrite_existing, error);
      if (!error) std::filesystem::remove(entry.path(), error);
    }
  }

  bool Report() {
    if (const auto merged = MergeLatencyTables(wanted_.out); !merged) Print(merged.error().detail);
    RunFacts facts;
    facts.is_completed = is_final_;
    facts.why = why_;
    facts.seed = wanted_.plan.seed;
    facts.seconds = seconds_;
    facts.dead.assign(dead_.begin(), dead_.end());
    facts.missing_nodes = wanted_.plan.without;
    const nlohmann::json report = MergeReport(scenario_, facts, wanted_.out);
    if (!WriteReport(report, wanted_.out)) {
      Print("cannot write " + wanted_.out.string());
      return false;
    }
    Print(Summarise(report));
    Print("report, logs and clocks in " + wanted_.out.string());
    return true;
  }

  const scene::Scenario& scenario_;
  const lab::Lab& lab_;
  Wanted wanted_;
  const std::atomic<int>& interrupted_;
  PreflightOptions preflight_;
  Remotes remotes_;
  AllFacts facts_;
  std::vector<std::string> roots_;  // in the order of the hosts
  bool has_leases_ = false, is_started_ = false, is_stopping_ = false, is_taken_over_ = false, is_final_ = false;
  lab::Plan plan_;
  LaunchKeys keys_;
  LogStreams streams_;
  std::optional<Comebacks> comebacks_;
  BusStory story_;
  std::set<std::string> expected_, dead_;                  // nodes
  std::map<std::string, std::set<std::string>> nodes_of_;  // by unit
  std::vector<std::unique_ptr<ClockSeries>> clocks_;
  std::ofstream clock_file_;
  std::int64_t clocks_read_ns_ = 0, taken_over_asked_ns_ = 0, start_ns_ = 0, ready_ns_ = 0;
  double seconds_ = 0.0;
  std::string why_;
};

// Prints the plan as far as it is known without contacting the hosts.
void ShowPlan(const lab::Lab& lab, const scene::Scenario& scenario, const Wanted& wanted) {
  std::map<std::string, lab::HostFacts> facts;
  for (const lab::Host& host : lab.hosts) {
    const std::string root = host.run_folder.front() == '/' ? host.run_folder : "~/" + host.run_folder;
    facts[host.name] = {root,
                        host.bind.empty() ? host.address : host.bind,
                        host.programs.empty() ? root + "/programs/..." : host.programs,
                        root + "/assets/.../" + scenario.file.filename().string(),
                        "~",
                        ":120",
                        root + "/page/...",
                        root + "/page/.../build/release/clients/stubs"};
  }
  Print(lab::Describe(lab::MakePlan(lab, facts, wanted.plan)) + "nothing was started (--dry-run)");
}

// The run's name becomes part of folders and commands on all hosts, so it has plain characters only.
std::string RunName(const std::string& scenario) {
  std::string name;
  for (const char c : scenario) name += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' ? c : '_';
  return name + "-" + Stamp("%Y%m%d-%H%M%S") + "-" + std::to_string(getpid());
}

core::Result<Wanted> ReadWanted(const Arguments& arguments, const scene::Scenario& scenario) {
  Wanted wanted;
  const auto seed = arguments.count("--seed", 0, kLargestSeed), workers = arguments.count("--workers", 1, kMostWorkers);
  const auto duration = arguments.positive("--duration");
  if (!seed) return tl::unexpected(seed.error());
  if (!workers) return tl::unexpected(workers.error());
  if (!duration) return tl::unexpected(duration.error());
  wanted.plan.method = scenario.method;
  wanted.plan.run = RunName(scenario.name);
  const std::int64_t chance[2] = {core::MonotonicNow_ns(), getpid()};
  wanted.plan.session = core::Hash64(chance, sizeof chance) | 1U;  // never 0
  wanted.plan.seed = seed->value_or(scenario.seed);
  wanted.plan.workers = static_cast<unsigned>(workers->value_or(1));
  wanted.plan.without = arguments.texts("--without");
  wanted.plan.is_recorded = arguments.has("--record");
  wanted.plan.has_keys = true;
  wanted.duration_s = *duration;
  wanted.plan.records_steps = arguments.has("--steps");
  if (arguments.has("--record")) wanted.record = std::filesystem::absolute(arguments.text("--record"));
  if (arguments.has("--steps")) wanted.steps = std::filesystem::absolute(arguments.text("--steps"));
  wanted.out = std::filesystem::absolute(arguments.text("--out", "out/" + wanted.plan.run));
  return wanted;
}

int RunLaunch(const Arguments& arguments) {
  const CheckOutcome check = CheckScenario(FindScenario(arguments.positional()[0]));
  for (const std::string& line : check.problems) std::fprintf(stderr, "%s\n", line.c_str());
  if (!check.scenario || !check.problems.empty()) {
    return Complain("launch", "the scenario is broken, nothing was started", kBadUsage);
  }
  scene::Scenario scenario = *check.scenario;
  scenario.method = arguments.text("--method", scenario.method);
  if (!vps::MethodFromName(scenario.method)) {
    return Complain("launch", "--method is paper or fast, not '" + scenario.method + "'", kBadUsage);
  }
  if (const auto known = CheckNodeNames(arguments.texts("--without")); !known) {
    return Complain("launch", known.error().detail, kBadUsage);
  }
  if (!arguments.has("--lab")) return Complain("launch", "--lab LAB.xml is missing", kBadUsage);
  const auto lab = lab::LoadLab(arguments.text("--lab"));
  const auto problems = lab ? lab::CheckAgainst(*lab, scenario, arguments.texts("--without")) : lab.error();
  for (const scene::Diagnostic& problem : problems) std::fprintf(stderr, "%s\n", scene::Format(problem).c_str());
  if (!problems.empty()) return Complain("launch", "the lab file is broken, nothing was started", kBadUsage);
  const auto wanted = ReadWanted(arguments, scenario);
  if (!wanted) return Complain("launch", wanted.error().detail, kBadUsage);
  if (arguments.has("--dry-run")) {
    ShowPlan(*lab, scenario, *wanted);
    return kHolds;
  }
  return Launch(scenario, *lab, *wanted).Run();
}

}  // namespace

Verb LaunchVerb() {
  return {"launch",
          "starts the nodes on the machines of a lab, waits for the procedure's end, writes a report",
          "SCENARIO",
          1,
          1,
          {{"--lab", "LAB.xml", "the machines, and what runs on each"},
           {"--dry-run", "", "show the plan, start nothing"},
           {"--seed", "N", "seed of the simulated operator; default: the scenario's"},
           {"--duration", "S", "time limit; default: the scenario's"},
           {"--out", "DIR", "folder for the report, logs and clock series; default: out/<run>"},
           {"--record", "DIR", "record the traffic into this folder"},
           {"--steps", "DIR", "record every step of physics_node, haptic_node and logic_node, for 'oos replay'"},
           {"--method", "paper|fast", "collision method; default: the scenario's"},
           {"--workers", "N", "threads of the collision computation; default: 1"},
           {"--without", "NODE", "leave a node out, e.g. visual_node (repeatable)"}},
          RunLaunch,
          "Ctrl-C stops everything on all machines. From another terminal: oos status, attach, stop --lab LAB.xml.\n"
          "docs/howto/lab.md takes a lab from bare Debian hosts to a running scenario."};
}

}  // namespace oos
