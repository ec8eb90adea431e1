#include "tools/oos/run/session/session.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <memory>
#include <set>

#include "bus/membership/registry.hpp"
#include "bus/node.hpp"
#include "bus/security/keys.hpp"
#include "core/clock.hpp"
#include "core/hash.hpp"
#include "lab/lab.hpp"
#include "scene/limit_reached.hpp"
#include "tiles/seats.hpp"
#include "tools/oos/attach/places.hpp"
#include "tools/oos/attach/session_note.hpp"
#include "tools/oos/run/session/log_tail.hpp"
#include "tools/oos/run/session/virtual_display.hpp"

namespace oos {
namespace {

constexpr std::int64_t kPollPeriod_ns = 20'000'000;
constexpr double kStopPatience_s = 3.0;
// The viewer still makes pictures of the last step: two that workers trace, in up to 5 s each, and draws them.
constexpr double kPicturePatience_s = 15.0;
constexpr const char* kViewer = "visual_node";
constexpr double kProgressPeriod_s = 2.0;
constexpr std::int64_t kStartProgressPeriod_ns = 1'000'000'000;
// After a node has died the others have this time to notice and report it before they are stopped.
constexpr std::int64_t kLinger_ns = 800'000'000;

// Writes the note for the verbs that join the session; removes it at the end.
class NoteKeeper {
 public:
  core::Result<void> Write(const SessionNote& note) {
    auto written = WriteSessionNote(ToJson(note));
    is_written_ = written.has_value();
    return written;
  }
  NoteKeeper() = default;
  NoteKeeper(const NoteKeeper&) = delete;
  NoteKeeper& operator=(const NoteKeeper&) = delete;
  ~NoteKeeper() {
    std::error_code error;
    if (is_written_) std::filesystem::remove(SessionFile(), error);
  }

 private:
  bool is_written_ = false;
};

// New keys for the nodes, for the tools ("oos") and for clients that users attach. They are deleted with the run, so
// that captured traffic cannot be decrypted later.
class RunKeys {
 public:
  core::Result<void> Make(const std::filesystem::path& directory) {
    std::vector<std::string> names(std::begin(kNodeNames), std::end(kNodeNames));
    names.insert(names.end(), {"rt_worker", "oos", "client"});
    std::error_code error;
    directory_ = std::filesystem::absolute(directory);
    std::filesystem::remove_all(directory_, error);
    return bus::MakeKeys(directory_, names);
  }
  RunKeys() = default;
  RunKeys(const RunKeys&) = delete;
  RunKeys& operator=(const RunKeys&) = delete;
  ~RunKeys() {
    std::error_code error;
    if (!directory_.empty()) std::filesystem::remove_all(directory_, error);
  }
  [[nodiscard]] std::string directory() const { return directory_.string(); }  // empty: not encrypted

 private:
  std::filesystem::path directory_;
};

std::uint64_t NewSession() {
  const std::int64_t seed[2] = {core::MonotonicNow_ns(), getpid()};
  return core::Hash64(seed, sizeof seed) | 1U;  // never 0
}

std::string Seconds(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%6.1f s", seconds);
  return text;
}

class Session {
 public:
  Session(const scene::Scenario& scenario, const SessionOptions& options) : scenario_(scenario), options_(options) {
    outcome_.seed = options.seed.value_or(scenario.seed);
  }

  core::Result<SessionOutcome> Run() {
    const core::Result<void> started = Start();
    if (!started) return core::Fail(started.error().code, started.error().detail);
    const std::int64_t ready_ns = WaitUntilReady();
    is_ready_ = outcome_.why.empty();
    if (is_ready_) Watch(ready_ns);
    if (!outcome_.dead.empty() && !outcome_.why.empty() && !IsInterrupted()) Linger();
    StopNodes();
    return outcome_;
  }

 private:
  // The nodes first, then the viewer, then workers and display, which must outlive it.
  void StopNodes() {
    Say("stopping");
    std::vector<std::string> nodes(processes_.begin(), processes_.end());
    group_.Terminate(nodes);
    std::erase(nodes, kViewer);
    if (!nodes.empty()) outcome_.killed = group_.StopAll(kStopPatience_s, nodes);
    const auto late = group_.StopAll(IsInterrupted() ? kStopPatience_s : kPicturePatience_s, {kViewer});
    outcome_.killed.insert(outcome_.killed.end(), late.begin(), late.end());
    group_.StopAll(kStopPatience_s);
    for (const std::string& name : outcome_.killed) Say(name + " did not stop on SIGTERM and was killed");
  }

  void Say(const std::string& line) const {
    if (options_.say) options_.say(line);
  }
  [[nodiscard]] bool IsWanted(const std::string& name) const {
    return std::find(options_.without.begin(), options_.without.end(), name) == options_.without.end();
  }
  [[nodiscard]] bool IsInterrupted() const {
    return options_.interrupted != nullptr && options_.interrupted->load() != 0;
  }

  core::Result<void> Start() {
    const std::uint64_t session = NewSession();
    if (options_.is_encrypted) {
      if (const auto made = keys_.Make(options_.out / "keys"); !made) return made;
    }
    auto registry = bus::Registry::Create({"tcp://127.0.0.1:0", session, keys_.directory(), options_.is_encrypted});
    if (!registry) return core::Fail(registry.error().code, registry.error().detail);
    registry_ = std::move(*registry);
    bus::NodeOptions node_options;
    node_options.name = "oos";
    node_options.registry = registry_->endpoint();
    node_options.session = session;
    node_options.is_observer = true;
    node_options.keys = keys_.directory();
    node_options.is_encrypted = options_.is_encrypted;
    auto node = bus::Node::Create(node_options);
    if (!node) return core::Fail(node.error().code, node.error().detail);
    node_ = std::move(*node);
    status_ = &node_->ReadState<core::LogicStatus>(bus::kLogicStatusTopic);
    if (options_.while_running && !scenario_.devices.empty()) {
      command_ = &node_->ReadLatest<core::DeviceCommand>(bus::DeviceCommandTopic(scenario_.devices[0].role));
    }
    node_->ReadEvents();
    if (const auto started = node_->Start(); !started) return started;
    SessionNote note{registry_->endpoint(), std::to_string(session), getpid(),
                     options_.out.string(), keys_.directory(),       scenario_.file.string()};
    if (auto noted = note_.Write(note); !noted) return noted;
    return SpawnNodes(session);
  }

  core::Result<void> SpawnNodes(std::uint64_t session) {
    std::map<std::string, std::string> visual_environment = {{"LP_NUM_THREADS", "1"}};
    const char* display = std::getenv("DISPLAY");
    const bool has_display = display != nullptr && *display != '\0';
    if (IsWanted(kViewer) && (options_.is_headless || !has_display)) {
      auto virtual_display = StartVirtualDisplay(&group_, options_.out / "Xvfb.log");
      if (!virtual_display) return core::Fail(virtual_display.error().code, virtual_display.error().detail);
      visual_environment["DISPLAY"] = *virtual_display;
    }
    for (const std::string node : kNodeNames) {
      if (!IsWanted(node)) continue;
      expected_.insert(node);
      if (options_.is_colocated && node == "physics_node") continue;  // with haptic_node
      const bool is_pair = options_.is_colocated && node == "haptic_node";
      const std::string name = is_pair ? lab::kColocatedProgram : node;
      process::Command command;
      command.name = name;
      command.program = options_.program_folder / name;
      command.arguments = {"--scenario", scenario_.file.string(), "--registry", registry_->endpoint(),
                           "--session",  std::to_string(session), "--out",      options_.out.string()};
      if (options_.is_encrypted) {
        AddArgument(&command, "--keys", keys_.directory());
      } else {
        command.arguments.push_back("--no_encryption");
      }
      const bool writes_latest = name != kViewer;  // which gets its own datagrams, group or not
      if (writes_latest && !options_.tcp_topics.empty()) AddArgument(&command, "--tcp_topics", options_.tcp_topics);
      if (writes_latest && !options_.multicast.empty()) AddArgument(&command, "--multicast", options_.multicast);
      if (name == "device_bridge") {
        AddArgument(&command, "--seed", std::to_string(outcome_.seed));
        if (options_.hand != "script") AddArgument(&command, "--hand", options_.hand);
        for (const std::string& device : options_.devices) AddArgument(&command, "--device", device);
      }
      if (node == "haptic_node" || node == "physics_node") {
        AddArgument(&command, "--workers", std::to_string(options_.workers));
        AddArgument(&command, "--method", scenario_.method);
      }
      // A person takes as long as a person takes.
      if (node == "logic_node" && options_.hand == "pointer") AddArgument(&command, "--stall_limit_s", "3600");
      if (node == "haptic_node") AddArgument(&command, "--coupling", scenario_.coupling.type);
      if (name != kViewer && name != "logic_node") AddArgument(&command, "--rt", options_.rt);
      if (name == kViewer) {
        if (options_.rays > 0) command.program = options_.program_folder / "rt_visual_node";
        command.environment = visual_environment;
        outcome_.had_window = !options_.is_headless && has_display;
        if (!outcome_.had_window) command.arguments.push_back("--headless");
        if (options_.hand == "pointer") command.arguments.push_back("--hand");
        if (!options_.show.empty()) AddArgument(&command, "--show", options_.show);
      }
      // A process of two nodes names the files itself.
      const auto file = [&](const std::filesystem::path& folder) {
        return (is_pair ? folder : folder / (node + ".mcap")).string();
      };
      if (!options_.steps.empty() && (node == "haptic_node" || node == "physics_node" || node == "logic_node")) {
        AddArgument(&command, "--steps", file(options_.steps));
      }
      if (options_.is_recorded) {
        AddArgument(&command, "--record", file(RecordingFolder(options_.out)));
        if (!options_.split_MB.empty()) AddArgument(&command, "--split_MB", options_.split_MB);
        if (!options_.split_s.empty()) AddArgument(&command, "--split_s", options_.split_s);
      }
      command.log = options_.out / (name + ".log");
      if (const auto pid = group_.Spawn(command); !pid) return core::Fail(pid.error().code, pid.error().detail);
      processes_.insert(name);
    }
    return IsWanted(kViewer) ? SpawnWorkers(session) : core::Result<void>();
  }

  // Who trace the viewer's pictures.
  core::Result<void> SpawnWorkers(std::uint64_t session) {
    for (unsigned seat = 1; seat <= options_.rays; ++seat) {
      process::Command command;
      command.name = tiles::WorkerName(kViewer, seat);
      command.program = options_.program_folder / "rt_worker";
      command.arguments = {"--scenario", scenario_.file.string(),
                           "--registry", registry_->endpoint(),
                           "--session",  std::to_string(session),
                           "--out",      options_.out.string(),
                           "--name",     command.name};
      if (options_.is_encrypted) {
        AddArgument(&command, "--keys", keys_.directory());
      } else {
        command.arguments.push_back("--no_encryption");
      }
      command.log = options_.out / (command.name + ".log");
      if (const auto pid = group_.Spawn(command); !pid) return core::Fail(pid.error().code, pid.error().detail);
      workers_.insert(command.name);
    }
    return {};
  }

  static void AddArgument(process::Command* command, const std::string& name, const std::string& value) {
    command->arguments.push_back(name);
    command->arguments.push_back(value);
  }

  // Processes events of the bus and ends of processes; sets `outcome_.why` if the run cannot go on.
  void Listen() {
    node_->Wait(core::MonotonicNow_ns() + kPollPeriod_ns);
    core::Event event;
    while (node_->PollEvent(&event)) {
      if (event.name == "ready") ready_.insert(event.source);
      outcome_.events.push_back(event);
    }
    for (const std::size_t index : group_.Reap()) {
      NoteEnd(group_.children()[index]);
    }
    if (IsInterrupted() && outcome_.why.empty()) outcome_.why = "interrupted";
  }

  void NoteEnd(const process::Group::Child& child) {
    const std::string text = child.name + " ended by itself: " + child.exit->Describe();
    Say(text + "; see " + (options_.out / (child.name + ".log")).string());
    if (workers_.count(child.name) != 0) return;  // the viewer goes on without it
    outcome_.dead.push_back(text);
    if (is_ready_ && child.name == kViewer) {
      Say("the run goes on without its picture: 'oos view' shows it again, Ctrl-C ends it");
    } else if (outcome_.why.empty()) {
      outcome_.why = text;
    }
  }

  // A node is ready when it has emitted "ready", or when the procedure runs (which needs all nodes).
  [[nodiscard]] bool AreAllReady() const {
    if (status_->has_value() && status_->value().time_ns > 0 && expected_.count("logic_node") != 0) return true;
    return std::includes(ready_.begin(), ready_.end(), expected_.begin(), expected_.end());
  }

  std::int64_t WaitUntilReady() {
    Say("starting " + std::to_string(expected_.size()) + " nodes; the first run of a scene cooks its structures");
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    std::set<std::string> announced;
    std::map<std::string, LogTail> logs;
    for (const std::string& name : processes_) logs.emplace(name, options_.out / (name + ".log"));
    std::int64_t next_progress_ns = begin_ns + kStartProgressPeriod_ns;
    while (outcome_.why.empty() && !AreAllReady()) {
      Listen();
      if (core::MonotonicNow_ns() >= next_progress_ns) {
        next_progress_ns += kStartProgressPeriod_ns;
        SayWhatNodesDo(&logs);
      }
      for (const std::string& name : ready_) {
        if (announced.insert(name).second) Say(name + " is ready");
      }
      if (static_cast<double>(core::MonotonicNow_ns() - begin_ns) * 1e-9 > options_.start_patience_s) {
        std::string missing;
        for (const std::string& name : expected_) {
          if (ready_.count(name) == 0) missing += " " + name;
        }
        outcome_.why = "not ready in time:" + missing + "; see the logs in " + options_.out.string();
      }
    }
    return core::MonotonicNow_ns();
  }

  // Cooking takes a while, and the nodes write in their logs how far they are.
  void SayWhatNodesDo(std::map<std::string, LogTail>* logs) const {
    for (auto& [name, log] : *logs) {
      const std::string line = log.NewestLine();
      if (ready_.count(name) == 0 && !line.empty()) Say(name + ": " + line);
    }
  }

  [[nodiscard]] double Force_N() const {
    return command_ != nullptr ? glm::length(command_->value().F_Do_W.force_N) : 0.0;
  }

  void Linger() {
    const std::int64_t until_ns = core::MonotonicNow_ns() + kLinger_ns;
    while (core::MonotonicNow_ns() < until_ns && !IsInterrupted()) Listen();
    for (const core::Event& event : outcome_.events) {
      if (event.name == "node_lost" || event.name == "force_faded") {
        Say(event.source + " reports: " + event.name + " " + event.detail);
      }
    }
  }

  void Watch(std::int64_t ready_ns) {
    const double limit_s = options_.duration_s.value_or(scenario_.duration_limit_s);
    double next_progress_s = 0.0;
    while (true) {
      Listen();
      outcome_.seconds = static_cast<double>(core::MonotonicNow_ns() - ready_ns) * 1e-9;
      if (options_.while_running) options_.while_running(group_, outcome_.seconds, Force_N());
      if (status_->has_value()) {
        const core::LogicStatus& status = status_->value();
        if (status.step != outcome_.last_step) {
          outcome_.last_step = status.step;
          Say(Seconds(outcome_.seconds) + "  step " + status.step + (status.hint.empty() ? "" : ": " + status.hint));
          next_progress_s = outcome_.seconds + kProgressPeriod_s;
        }
        outcome_.is_final = status.is_final && !status.is_failed;
        if (status.is_failed) outcome_.why = status.why.empty() ? "failed in step " + status.step : status.why;
        if (status.is_final || status.is_failed) return;
      }
      if (!outcome_.why.empty()) return;
      if (outcome_.seconds > limit_s) {
        outcome_.why = scene::LimitReached(limit_s, outcome_.last_step);
        return;
      }
      if (outcome_.seconds >= next_progress_s) {
        Say(Seconds(outcome_.seconds) + "  in step " + (outcome_.last_step.empty() ? "-" : outcome_.last_step));
        next_progress_s += kProgressPeriod_s;
      }
    }
  }

  const scene::Scenario& scenario_;
  const SessionOptions& options_;
  SessionOutcome outcome_;
  RunKeys keys_;
  std::unique_ptr<bus::Registry> registry_;
  std::unique_ptr<bus::Node> node_;
  bus::StateReader<core::LogicStatus>* status_ = nullptr;
  bus::LatestReader<core::DeviceCommand>* command_ = nullptr;
  NoteKeeper note_;
  std::set<std::string> expected_;   // nodes
  std::set<std::string> processes_;  // that run them
  std::set<std::string> workers_;    // that trace pictures
  std::set<std::string> ready_;
  bool is_ready_ = false;  // the session
  process::Group group_;   // last member: stopped first
};

}  // namespace

std::filesystem::path RecordingFolder(const std::filesystem::path& out) {
  return out / "recording";
}

core::Result<SessionOutcome> RunSession(const scene::Scenario& scenario, const SessionOptions& options) {
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) return core::Fail(core::ErrorCode::kIo, "cannot make " + options.out.string() + ": " + error.message());
  Session session(scenario, options);
  return session.Run();
}

}  // namespace oos
