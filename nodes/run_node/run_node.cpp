#include "nodes/run_node/run_node.hpp"

#include <csignal>
#include <cstdio>
#include <deque>
#include <memory>

#include "bus/log/node_recording.hpp"
#include "bus/log/step_log.hpp"
#include "collision/resolution/choose_resolutions.hpp"
#include "core/clock.hpp"
#include "nodes/run_node/command_line.hpp"
#include "replay/open_step_log.hpp"
#include "replay/platform.hpp"

namespace run_node {
namespace {

std::atomic<bool> is_stop_wanted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

void WantStop(int /*signal*/) {
  is_stop_wanted.store(true);
}

cli::Syntax SyntaxOf(const Program& program, bool is_alone) {
  cli::Syntax syntax;
  syntax.program = program.name;
  syntax.summary = program.summary;
  syntax.options = {{"--scenario", "FILE", "what is simulated"}, {"--out", "DIR", "of the report"}};
  for (const cli::Option& option : BusOptions()) syntax.options.push_back(option);
  syntax.options.push_back({"--tcp_topics", "PATTERNS", "LATEST topics that go by ZeroMQ instead of UDP, with commas"});
  syntax.options.push_back({"--multicast", "GROUP:PORT", "LATEST goes once to a group; default: to each reader"});
  if (!program.thread.empty()) {
    syntax.options.push_back({"--rt", "try|off|enforce", "real-time priority", "try", cli::OneOf("try|off|enforce")});
  }
  if (program.can_record_steps) {
    syntax.options.push_back({"--steps", "FILE.mcap", "every step with all that it reads, for 'oos replay'"});
  }
  syntax.options.insert(syntax.options.end(), program.options.begin(), program.options.end());
  for (cli::Option& option : syntax.options) {
    if (is_alone || (option.name != "--record" && option.name != "--steps")) continue;
    option.value_name = "DIR";
    option.help = option.name == "--record" ? "for each node NODE.mcap of what it sends and takes"
                                            : "for each node NODE.mcap of every step with all that it reads";
  }
  syntax.details = "'oos run' and 'oos launch' start the nodes of a run.";
  return syntax;
}

// One node of the process, between the command line and the exit status.
class Life {
 public:
  // `is_alone`: --record and --steps name its files; else folders.
  Life(const Program& program, Member member, bool is_alone, const Setting& setting)
      : program_(program), member_(std::move(member)), is_alone_(is_alone), setting_(setting) {}

  core::Result<void> Open() {
    if (auto built = member_.body->Build(setting_); !built) return built;
    if (auto joined = Join(); !joined) return joined;
    return OpenSteps();
  }
  core::Result<void> Start() { return node_->Start(); }
  void OnStart() { member_.body->OnStart(); }
  void SayReady() { node_->Emit({core::MonotonicNow_ns(), node_->name(), "ready", std::string(member_.ready)}); }
  void Run() { member_.body->Run(is_stop_wanted); }

  core::Result<void> Finish(bool is_realtime) {
    if (auto stopped = bus::log::StopRecording(recording_.get()); !stopped) return stopped;
    if (steps_ != nullptr) {
      if (auto closed = steps_->Close(); !closed) return closed;
      std::printf("steps that were not recorded: %llu\n", static_cast<unsigned long long>(steps_->num_lost()));
    }
    return member_.body->WriteReport(is_realtime);
  }

 private:
  // The file of an option; empty without it.
  [[nodiscard]] std::string File(std::string_view option) const {
    const std::string path = setting_.arguments.text(option);
    if (path.empty() || is_alone_) return path;
    return (std::filesystem::path(path) / (member_.name + ".mcap")).string();
  }

  core::Result<void> Join() {
    const bus::NodeOptions options =
        MakeNodeOptions(setting_.arguments.text("--name", member_.name), setting_.arguments);
    std::vector<bus::log::Metadata> about;
    if (program_.can_record_steps) about.push_back({"platform", replay::DescribePlatform()});
    bus::log::RecordingOptions to = MakeRecordingOptions(setting_.arguments);
    to.file = File("--record");
    auto recording = bus::log::StartRecording(options.name, to, std::move(about));
    if (!recording) return tl::unexpected(recording.error());
    recording_ = std::move(*recording);
    auto node = bus::Node::Create(bus::log::WithTap(options, recording_.get()));
    if (!node) return tl::unexpected(node.error());
    node_ = std::move(*node);
    return member_.body->Connect(node_.get(), options);
  }

  core::Result<void> OpenSteps() {
    const std::string file = File("--steps");
    if (file.empty()) return {};
    auto format = member_.body->DescribeSteps();
    if (!format) return tl::unexpected(format.error());
    bus::log::TextMap about = replay::DescribeRun(setting_.scenario);
    for (auto& [name, value] : format->about) about[name] = std::move(value);
    if (!program_.thread.empty()) about["denormals"] = "flushed";  // by SetUpThread
    auto steps = replay::OpenStepLog(file, member_.name, format->fields, about, format->checkpoint);
    if (!steps) return tl::unexpected(steps.error());
    steps_ = std::move(*steps);
    member_.body->RecordSteps(steps_.get());
    return {};
  }

  const Program& program_;
  // Each outlives the next, which uses it.
  std::unique_ptr<bus::log::TapRecorder> recording_;
  std::unique_ptr<bus::Node> node_;
  std::unique_ptr<bus::log::StepLog> steps_;
  Member member_;
  bool is_alone_;
  const Setting& setting_;
};

bus::ThreadReport SetUpLoopThread(const Program& program, const Setting& setting) {
  if (program.thread.empty()) return {};
  bus::ThreadSetup setup;
  setup.name = program.thread;
  setup.mode = setting.mode;
  setup.fifo_priority = program.fifo_priority;
  bus::ThreadReport report = bus::SetUpThread(setup);
  std::printf("%s\n", report.text.c_str());
  return report;
}

core::Result<void> RunLives(const Program& program, const Setting& setting, std::deque<Life>* lives) {
  for (Life& life : *lives) {
    if (auto opened = life.Open(); !opened) return opened;
  }
  for (Life& life : *lives) {
    if (auto started = life.Start(); !started) return started;
  }
  const bus::ThreadReport thread = SetUpLoopThread(program, setting);
  if (!thread.is_ok) return core::Fail(core::ErrorCode::kResource, "no real-time priority: " + thread.text);
  for (Life& life : *lives) life.OnStart();
  std::printf("ready\n");
  std::fflush(stdout);
  for (Life& life : *lives) life.SayReady();
  lives->back().Run();
  for (Life& life : *lives) {
    if (auto finished = life.Finish(thread.is_fifo); !finished) return finished;
  }
  return {};
}

}  // namespace

int RunNode(int argc, char** argv, const Program& program, std::unique_ptr<Body> body) {
  std::vector<Member> members;
  members.push_back({program.name, program.ready, std::move(body)});
  return RunNodes(argc, argv, program, std::move(members));
}

int RunNodes(int argc, char** argv, const Program& program, std::vector<Member> members) {
  int status = kDone;
  const auto arguments = ReadCommandLine(argc, argv, SyntaxOf(program, members.size() == 1), &status);
  if (!arguments) return status;
  if (const auto good = CheckBusOptions(*arguments); !good) {
    return Report(program.name, good.error().detail, kBadUsage);
  }
  std::signal(SIGTERM, WantStop);
  std::signal(SIGINT, WantStop);
  auto scenario = ReadScenario(program.name, arguments->text("--scenario"));
  if (!scenario) return kBadUsage;
  if (const std::string method = arguments->text("--method"); !method.empty() && method != scenario->method) {
    scenario->method = method;
    if (const auto chosen = collision::ChooseResolutions(&*scenario); !chosen) {
      return Report(program.name, scene::Format(chosen.error().front()), kBadUsage);
    }
  }
  if (const std::string coupling = arguments->text("--coupling"); !coupling.empty()) scenario->coupling.type = coupling;
  Setting setting{*arguments, *scenario, bus::RealTimeMode::kOff, arguments->text("--out")};
  bus::ParseRealTimeMode(arguments->text("--rt", "off"), &setting.mode);
  std::deque<Life> lives;  // the last one's node uses the others'
  const bool is_alone = members.size() == 1;
  for (Member& member : members) lives.emplace_back(program, std::move(member), is_alone, setting);
  const auto done = RunLives(program, setting, &lives);
  if (done) return kDone;
  return Report(program.name, done.error().detail,
                done.error().code == core::ErrorCode::kInvalidInput ? kBadUsage : kFailed);
}

void PrintLine(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
}

core::Result<void> CheckWritten(bool is_written, const std::filesystem::path& out) {
  if (is_written) return {};
  return core::Fail(core::ErrorCode::kIo, "cannot write its report to " + out.string() + "; is the folder writable?");
}

cli::Option WorkersOption() {
  return {"--workers", "N", "threads of the collision computation", "1", cli::Count(1, 64)};
}

cli::Option MethodOption() {
  return {"--method", "paper|fast", "collision method; default: the scenario's"};
}

cli::Option CacheOption() {
  return {"--cache", "DIR", "of cooked collision structures"};
}

}  // namespace run_node
