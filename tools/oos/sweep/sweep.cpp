// Design studies: runs a scenario many times with different values of its attributes.

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <utility>

#include "core/clock.hpp"
#include "scene/load_scenario.hpp"
#include "tools/oos/attach/attach.hpp"
#include "tools/oos/attach/places.hpp"
#include "tools/oos/sweep/sweep_plan.hpp"
#include "tools/oos/sweep/sweep_results.hpp"
#include "tools/oos/sweep/verbs.hpp"
#include "tools/oos/verb/find_scenario.hpp"
#include "tools/process/spawn.hpp"

namespace oos {
namespace {

constexpr double kMostSeeds = 10'000;
// The runs of a sweep that was just killed end meanwhile: GNU parallel gives them a third of a second.
constexpr std::int64_t kEndingPatience_ns = 3 * core::kNanosecondsPerSecond;

bench::Table PlanTable(const std::string& scenario, const std::vector<GridAxis>& axes,
                       const std::vector<SweepRun>& runs) {
  bench::Table table{"plan", {"run", "scenario"}, {}};
  for (const GridAxis& axis : axes) table.columns.push_back(axis.name);
  table.columns.emplace_back("seed");
  for (const SweepRun& run : runs) {
    std::vector<std::string> row = {run.name, scenario};
    row.insert(row.end(), run.values.begin(), run.values.end());
    row.push_back(std::to_string(run.seed));
    table.Add(std::move(row));
  }
  return table;
}

std::string ReadText(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

// One sweep at a time works in a folder. GNU parallel and the runs keep the lock too (it goes when the last of them has
// ended), so what a killed sweep left behind is not run a second time beside it.
class FolderLock {
 public:
  static core::Result<FolderLock> Take(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    const std::filesystem::path file = folder / "lock";
    FolderLock lock(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
    if (lock.fd_ < 0) {
      return core::Fail(core::ErrorCode::kIo,
                        "cannot write " + file.string() + ": " + std::strerror(errno) + "; is the folder writable?");
    }
    const std::int64_t deadline_ns = core::MonotonicNow_ns() + kEndingPatience_ns;
    while (flock(lock.fd_, LOCK_EX | LOCK_NB) != 0) {
      if (errno != EWOULDBLOCK) {
        return core::Fail(core::ErrorCode::kIo, "cannot lock " + file.string() + ": " + std::strerror(errno) +
                                                    "; choose an --out on a file system that has locks");
      }
      if (core::MonotonicNow_ns() > deadline_ns) return InUse(folder, ReadText(file));
      const timespec pause{0, 10'000'000};
      nanosleep(&pause, nullptr);
    }
    char host[256] = "";
    gethostname(host, sizeof host - 1);
    const std::string holder = "process " + std::to_string(getpid()) + " on " + host;
    if (ftruncate(lock.fd_, 0) != 0 || write(lock.fd_, holder.data(), holder.size()) < 0) {
      // Not an error: the text is only for the message to other sweeps.
    }
    return lock;
  }
  FolderLock(FolderLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock() {
    if (fd_ >= 0) close(fd_);
  }
  [[nodiscard]] int fd() const { return fd_; }

 private:
  explicit FolderLock(int fd) : fd_(fd) {}

  static tl::unexpected<core::Error> InUse(const std::filesystem::path& folder, const std::string& holder) {
    return core::Fail(core::ErrorCode::kResource,
                      folder.string() + " is in use by another sweep (" + holder +
                          "), or by runs that it left; wait for their end, stop them, or choose another --out");
  }

  int fd_ = -1;
};

bool IsInside(const std::filesystem::path& path, const std::filesystem::path& folder) {
  std::error_code error;
  const auto inner = std::filesystem::weakly_canonical(path, error);
  const auto outer = std::filesystem::weakly_canonical(folder, error);
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

// Quotes a text as one word of /bin/sh.
std::string Quote(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

core::Result<void> WriteRun(const scene::Scenario& scenario, const std::vector<GridAxis>& axes, const SweepRun& run,
                            const std::filesystem::path& folder) {
  if (auto copied = WriteScenarioCopy(scenario.file, axes, run.values, folder / "scenario"); !copied) return copied;
  const std::string script =
      "#!/bin/sh\n# One run of a sweep. Exit status 0: the procedure was completed. $OOS: the program, when it is "
      "elsewhere.\ncd \"$(dirname \"$0\")\" || exit 2\n[ -n \"$OOS\" ] || OOS=" +
      Quote(ProgramFolder() / "oos") + "\nexec \"$OOS\" run " +
      Quote(std::filesystem::path("scenario") / scenario.file.filename()) + " --lockstep --seed " +
      std::to_string(run.seed) + " --out out > log.txt 2>&1\n";
  if (auto written = bench::WriteFile(folder / "run.sh", script); !written) return written;
  std::error_code error;
  std::filesystem::permissions(folder / "run.sh", std::filesystem::perms::owner_all, error);
  return {};
}

// Folders of runs appear once all are good and the plan is written: what is in `runs` is never of another
// plan. A folder that has them already keeps them.
core::Result<void> WriteFolders(const scene::Scenario& scenario, const std::vector<GridAxis>& axes,
                                const std::vector<SweepRun>& runs, const std::filesystem::path& out) {
  std::error_code error;
  const std::string plan = bench::ToCsv(PlanTable(scenario.name, axes, runs));
  const std::filesystem::path file = out / "plan.csv";
  const bool has_plan = std::filesystem::exists(file, error);
  if (has_plan ? ReadText(file) != plan : std::filesystem::exists(out / "runs", error)) {
    return core::Fail(core::ErrorCode::kInvalidInput, out.string() + " holds another sweep (" + file.string() +
                                                          (has_plan ? " differs" : " is missing") +
                                                          "); choose another --out, or remove it");
  }
  // Stays when a run is refused: the message names a file in it.
  const std::filesystem::path unfinished = out / "runs.unfinished";
  std::filesystem::remove_all(unfinished, error);
  std::vector<std::string> names;
  for (const SweepRun& run : runs) {
    if (std::filesystem::exists(out / "runs" / run.name, error)) continue;
    if (auto written = WriteRun(scenario, axes, run, unfinished / run.name); !written) {
      return core::Fail(written.error().code, "run " + run.name + ": " + written.error().detail);
    }
    names.push_back(run.name);
  }
  if (auto written = bench::WriteFile(file, plan); !written) return written;
  std::filesystem::create_directories(out / "runs", error);
  for (const std::string& name : names) {
    std::filesystem::rename(unfinished / name, out / "runs" / name, error);
    if (error) {
      return core::Fail(core::ErrorCode::kIo, "cannot make " + (out / "runs" / name).string() + ": " + error.message() +
                                                  "; is the folder writable?");
    }
  }
  std::filesystem::remove(unfinished, error);
  return {};
}

std::vector<SweepOutcome> ReadOutcomes(const std::vector<SweepRun>& runs, const std::filesystem::path& out) {
  std::vector<SweepOutcome> outcomes;
  for (const SweepRun& run : runs) outcomes.push_back(ReadOutcome(out / "runs" / run.name));
  return outcomes;
}

// Writes the runs that have left no report yet to jobs.txt. Returns their number.
core::Result<std::size_t> WriteJobs(const std::vector<SweepRun>& runs, const std::filesystem::path& out) {
  const std::vector<SweepOutcome> outcomes = ReadOutcomes(runs, out);
  std::string names;
  std::size_t num_jobs = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (outcomes[i].has_report) continue;
    names += "runs/" + runs[i].name + "\n";
    ++num_jobs;
  }
  if (auto written = bench::WriteFile(out / "jobs.txt", names); !written) return tl::unexpected(written.error());
  return num_jobs;
}

// Runs jobs.txt by GNU parallel. It gets SIGINT by Ctrl-C, and from the kernel when this process is killed; then it
// ends its runs. (It ignores SIGTERM until its first run.)
core::Result<void> RunJobs(const Arguments& arguments, const FolderLock& lock, const std::filesystem::path& out) {
  process::Command parallel;
  parallel.name = "GNU parallel";
  parallel.program = "parallel";
  parallel.folder = out;
  parallel.inherited_fd = lock.fd();
  parallel.arguments = {"--will-cite", "--joblog", "jobs.log", "--arg-file", "jobs.txt"};
  if (arguments.has("--jobs"))
    parallel.arguments.insert(parallel.arguments.end(), {"--jobs", arguments.text("--jobs")});
  if (arguments.has("--hosts")) {
    parallel.arguments.insert(parallel.arguments.end(),
                              {"--sshlogin", arguments.text("--hosts"), "--workdir", "...", "--transferfile", "{}",
                               "--return", "{}/out", "--return", "{}/log.txt", "--cleanup", "--env", "OOS"});
  }
  parallel.arguments.emplace_back("{}/run.sh");
  process::Bond bond;
  bond.group = process::Bond::Group::kCallers;
  bond.signal_at_owners_end = SIGINT;
  const auto child = process::Spawn(parallel, bond);
  if (!child && child.error().code == core::ErrorCode::kNotFound) {
    return core::Fail(core::ErrorCode::kNotFound,
                      "GNU parallel cannot be started; install Debian's package 'parallel', or run the folders of " +
                          (out / "jobs.txt").string() + " by other means");
  }
  if (!child) return tl::unexpected(child.error());
  const process::Exit exit = process::Wait(*child);
  // Its exit status counts the runs that were not completed.
  if (exit.signal == 0 && exit.status < 126) return {};
  return core::Fail(core::ErrorCode::kResource, "stopped before the end; the same command goes on from here");
}

core::Result<void> WriteResults(const std::string& scenario, const std::vector<GridAxis>& axes,
                                const std::vector<SweepRun>& runs, const std::vector<SweepOutcome>& outcomes,
                                const std::filesystem::path& out) {
  const std::string table = bench::ToCsv(ResultTable(axes, runs, outcomes));
  if (auto written = bench::WriteFile(out / "results.csv", table); !written) return written;
  return bench::WriteFile(out / "results.svg", ResultChart(scenario, axes, runs, outcomes));
}

int RunSweep(const Arguments& arguments) {
  const auto seeds = arguments.number("--seeds");
  if (!seeds) return Complain("sweep", seeds.error().detail, kBadUsage);
  const double num_seeds = seeds->value_or(1.0);
  if (num_seeds < 1.0 || num_seeds > kMostSeeds) return Complain("sweep", "--seeds is from 1 to 10000", kBadUsage);
  if (!arguments.has("--grid") && !arguments.has("--seeds"))
    return Complain("sweep", "name what varies with --grid or --seeds, see oos sweep --help", kBadUsage);
  std::vector<GridAxis> axes;
  for (const std::string& text : arguments.texts("--grid")) {
    auto axis = ParseAxis(text);
    if (!axis) return Complain("sweep", axis.error().detail, kBadUsage);
    axes.push_back(std::move(*axis));
  }
  const auto scenario = scene::LoadScenario(FindScenario(arguments.positional()[0]));
  if (!scenario) {
    for (const scene::Diagnostic& diagnostic : scenario.error()) {
      std::fprintf(stderr, "%s\n", scene::Format(diagnostic).c_str());
    }
    return kBadUsage;
  }
  const std::filesystem::path out = std::filesystem::absolute(arguments.text("--out", "out/sweep-" + scenario->name));
  if (IsInside(out, scenario->folder)) {
    return Complain("sweep",
                    out.string() + " is inside the scenario's own folder " + scenario->folder.string() +
                        ", which every run gets a copy of; choose an --out elsewhere",
                    kBadUsage);
  }
  const auto lock = FolderLock::Take(out);
  if (!lock) return Complain("sweep", lock.error().detail, kDoesNotHold);
  const std::vector<SweepRun> runs = PlanRuns(axes, static_cast<unsigned>(num_seeds));
  if (auto written = WriteFolders(*scenario, axes, runs, out); !written) {
    return Complain("sweep", written.error().detail, kBadUsage);
  }
  const auto num_jobs = WriteJobs(runs, out);
  if (!num_jobs) return Complain("sweep", num_jobs.error().detail, kDoesNotHold);
  std::printf("%zu runs in %s, %zu of them still to be made\n", runs.size(), (out / "runs").c_str(), *num_jobs);
  std::fflush(stdout);
  if (arguments.has("--dry-run")) return kHolds;
  if (*num_jobs > 0) {
    if (auto run = RunJobs(arguments, *lock, out); !run) return Complain("sweep", run.error().detail, kDoesNotHold);
  }
  const std::vector<SweepOutcome> outcomes = ReadOutcomes(runs, out);
  if (auto written = WriteResults(scenario->name, axes, runs, outcomes, out); !written) {
    return Complain("sweep", written.error().detail, kDoesNotHold);
  }
  const auto num_completed =
      std::count_if(outcomes.begin(), outcomes.end(), [](const auto& o) { return o.is_completed; });
  const auto num_missing = std::count_if(outcomes.begin(), outcomes.end(), [](const auto& o) { return !o.has_report; });
  std::printf("%td of %zu runs completed their procedure: %s, %s\n", num_completed, runs.size(),
              (out / "results.csv").c_str(), (out / "results.svg").c_str());
  if (num_missing > 0) {
    return Complain(
        "sweep", std::to_string(num_missing) + " runs left no report; see their log.txt. The same command repeats them",
        kDoesNotHold);
  }
  return kHolds;
}

}  // namespace

Verb SweepVerb() {
  return {
      "sweep",
      "runs a scenario with other figures in it, many times: one table and one chart",
      "SCENARIO",
      1,
      1,
      {{"--grid", "NAME=LOW:HIGH:N", "what varies; or NAME=V,V,...; several make a grid. Default: only the seed"},
       {"--seeds", "N", "number of runs at each point, with seeds 1 to N; default 1"},
       {"--out", "DIR", "default out/sweep-<scenario>"},
       {"--jobs", "N", "number of runs at the same time; default: one per core"},
       {"--hosts", "HOST,HOST", "run on these hosts over ssh; ':' is this one. $OOS names the program there"},
       {"--dry-run", "",
        "only write the folders and jobs.txt, the list of runs to be made: those that have left no report yet"}},
      RunSweep,
      "NAME is an attribute of the scenario file: ATTRIBUTE (wherever it stands), ELEMENT.ATTRIBUTE or\n"
      "ELEMENT[NAME].ATTRIBUTE, e.g. --grid object[block].mass_kg=1:4:4 --grid run.method=paper,fast.\n"
      "DIR/runs/NNNNN is one run with all that it needs. Its run.sh runs it in lock-step, as fast as the machine can;\n"
      "exit status 0 means that the procedure was completed. GNU parallel runs them; a cluster's scheduler can run\n"
      "them as an array. The same command again runs only those that have no report.\n"
      "results.csv has a row per run, results.svg the means over the seeds. Exit status 0: every run has a report."};
}

}  // namespace oos
