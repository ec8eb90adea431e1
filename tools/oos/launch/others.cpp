// Verbs to observe and to stop a launched run, from any terminal that has the lab file.

#include <poll.h>
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "lab/load_lab.hpp"
#include "tools/oos/attach/attach.hpp"
#include "tools/oos/attach/lease.hpp"
#include "tools/oos/launch/verbs.hpp"
#include "tools/oos/launch/watch.hpp"

namespace oos {
namespace {

const std::vector<Option> kLabOption = {{"--lab", "LAB.xml", "the machines"}};
constexpr int kLauncherPatience_ms = 60'000;

// The lab with the hosts of one run.
struct Found {
  std::unique_ptr<Remotes> remotes;
  std::vector<std::string> complaints;  // one for each host that does not answer: what runs there is not known
  std::vector<HostState> states;
  Lease lease;                      // of the run; without values: none was found
  std::vector<std::string> roots;   // run folders on the hosts that it uses
  std::vector<std::string> others;  // hosts that another run uses, described
};

core::Result<Found> FindRun(const Arguments& arguments) {
  if (!arguments.has("--lab")) return core::Fail(core::ErrorCode::kInvalidInput, "--lab LAB.xml is missing");
  const auto lab = lab::LoadLab(arguments.text("--lab"));
  if (!lab) return core::Fail(core::ErrorCode::kInvalidInput, scene::Format(lab.error().front()));
  Found found;
  found.remotes = std::make_unique<Remotes>(lab->hosts);
  auto complaints = found.remotes->Reach();
  if (!complaints) return tl::unexpected(complaints.error());
  found.complaints = std::move(*complaints);
  auto states = ReadLeases(found.remotes.get());
  if (!states) return tl::unexpected(states.error());
  found.states = std::move(*states);
  found.lease = ChooseRun(found.states, lab->file.string());
  for (std::size_t i = 0; i < found.states.size(); ++i) {
    const HostState& state = found.states[i];
    const bool is_of_run = !state.lease.values.empty() && state.lease.value("run") == found.lease.value("run");
    found.roots.push_back(is_of_run ? state.root : "");
    if (is_of_run || state.lease.values.empty()) continue;
    found.others.push_back("host " + found.remotes->hosts()[i].name + " has another run: " + state.lease.Describe());
  }
  return found;
}

// Returns whether all hosts answer.
bool ReportSilentHosts(const Found& found) {
  for (const std::string& complaint : found.complaints) std::printf("%s\n", complaint.c_str());
  return found.complaints.empty();
}

int Status(const Arguments& arguments) {
  auto found = FindRun(arguments);
  if (!found) return Complain("status", found.error().detail, kBadUsage);
  std::vector<std::string> scripts;
  for (const HostState& state : found->states) {
    const std::string script = state.root + "/runs/" + state.lease.value("run") + "/status.sh";
    scripts.push_back(state.lease.values.empty() ? "" : "[ ! -e " + script + " ] || sh " + script + "\n");
  }
  const std::vector<Answer> answers = found->remotes->RunAll(scripts);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (!found->remotes->is_reached(i)) continue;
    const HostState& state = found->states[i];
    std::printf("%s: %s\n", found->remotes->hosts()[i].name.c_str(),
                state.lease.values.empty() ? "free" : state.lease.Describe().c_str());
    std::printf("%s", answers[i].out.c_str());
  }
  const bool do_all_answer = ReportSilentHosts(*found);
  return found->lease.values.empty() || !do_all_answer ? kDoesNotHold : kHolds;
}

bool IsLaunchedHere(const Lease& lease) {
  std::string boot;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> boot;
  return boot == lease.value("boot");
}

// Interrupts the launcher if it lives on this machine, and waits: it stops the run, collects its files and reports.
bool StopByLauncher(const Lease& lease) {
  const pid_t pid = static_cast<pid_t>(std::strtol(lease.value("pid").c_str(), nullptr, 10));
  std::ifstream name_file("/proc/" + std::to_string(pid) + "/comm");
  std::string name;
  name_file >> name;
  if (!IsLaunchedHere(lease) || pid <= 1 || name != "oos") return false;
  // The descriptor is readable once the process has ended, even before its parent has waited for it.
  pollfd ended{static_cast<int>(syscall(SYS_pidfd_open, pid, 0)), POLLIN, 0};
  if (ended.fd < 0) return false;
  const bool is_gone = kill(pid, SIGTERM) == 0 && poll(&ended, 1, kLauncherPatience_ms) == 1;
  close(ended.fd);
  return is_gone;
}

int Stop(const Arguments& arguments) {
  auto found = FindRun(arguments);
  if (!found) return Complain("stop", found.error().detail, kBadUsage);
  if (found->lease.values.empty()) {
    std::printf("nothing runs in this lab%s\n", found->complaints.empty() ? "" : ", as far as it answers");
    return ReportSilentHosts(*found) ? kHolds : kDoesNotHold;
  }
  const std::string run = found->lease.value("run");
  std::printf("stopping %s\n", found->lease.Describe().c_str());
  if (StopByLauncher(found->lease)) {
    std::printf("its launcher has stopped it; report in %s\n", found->lease.value("out").c_str());
    return kHolds;
  }
  // The launcher's own folder is a path of its machine.
  const std::string out =
      arguments.text("--out", IsLaunchedHere(found->lease) ? found->lease.value("out") : "out/" + run);
  MarkStopping(run, UserAtHost(), found->roots, found->remotes.get());
  const auto left = StopRun(run, found->roots, found->remotes.get());
  for (const std::string& line : left) std::printf("left over: %s\n", line.c_str());
  const auto collected = Collect(run, found->roots, out, found->remotes.get());
  ReleaseLeases(run, found->roots, found->remotes.get());
  for (const std::string& other : found->others) std::printf("%s; it goes on\n", other.c_str());
  const bool do_all_answer = ReportSilentHosts(*found);
  if (!collected) return Complain("stop", collected.error().detail, kDoesNotHold);
  std::printf("stopped; what it left is in %s\n", out.c_str());
  if (!do_all_answer) std::printf("what runs on hosts that do not answer goes on; stop it again when they do\n");
  return left.empty() && do_all_answer ? kHolds : kDoesNotHold;
}

int Follow(const Arguments& arguments) {
  auto found = FindRun(arguments);
  if (!found) return Complain("attach", found.error().detail, kBadUsage);
  ReportSilentHosts(*found);
  if (found->lease.values.empty()) return Complain("attach", "nothing runs in this lab", kDoesNotHold);
  std::printf("%s\n", found->lease.Describe().c_str());
  const std::string run = found->lease.value("run");
  std::vector<std::string> scripts;
  for (const std::string& root : found->roots) {
    scripts.push_back(root.empty() ? ""
                                   : "cd " + root + "/runs/" + run +
                                         " 2>/dev/null && for f in *.log; do echo unit=${f%.log}; done\n:\n");
  }
  std::vector<std::vector<std::string>> units;
  for (const Answer& answer : found->remotes->RunAll(scripts)) units.push_back(answer.values("unit"));
  LogStreams streams;
  if (const auto opened = streams.Open(run, found->roots, units, found->remotes.get()); !opened) {
    return Complain("attach", opened.error().detail, kDoesNotHold);
  }
  const std::atomic<int>& interrupted = CatchInterrupt();
  BusStory story;
  bool is_over = false;
  while (interrupted.load() == 0 && !is_over) {
    streams.Poll(100, [&](const std::string& host, const std::string& unit, const std::string& line) {
      const bool is_bus = unit == "registry";
      const std::string text = is_bus ? story.Take(line) : line;
      if (!text.empty()) std::printf("[%s] %s: %s\n", host.c_str(), is_bus ? "bus" : unit.c_str(), text.c_str());
      is_over = is_over || line.find("\"is\":\"down\"") != std::string::npos;
    });
    std::fflush(stdout);
    bool is_any_there = false;
    for (std::size_t i = 0; i < units.size(); ++i) {
      is_any_there = is_any_there || (!units[i].empty() && !streams.has_ended(i));
    }
    is_over = is_over || !is_any_there;
  }
  std::printf("%s\n", is_over ? "the run is over" : "detached; the run goes on");
  return kHolds;
}

}  // namespace

Verb AttachVerb() {
  return {"attach", "follows the logs of a launched run; Ctrl-C lets it go on", "", 0, 0, kLabOption, Follow};
}

Verb StatusVerb() {
  return {"status", "lists who runs what on each host of a lab", "", 0, 0, kLabOption, Status};
}

Verb StopVerb() {
  std::vector<Option> options = kLabOption;
  options.push_back(
      {"--out", "DIR",
       "folder for the run's files, if its launcher is gone; default: the launcher's, on other machines out/<run>"});
  return {"stop", "stops the run in a lab, whoever launched it, and collects its files", "", 0, 0, options, Stop};
}

}  // namespace oos
