// Design studies: the same scenario with other figures in it, many times.

#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "scene/load_scenario.hpp"
#include "tools/oos/attach.hpp"
#include "tools/oos/places.hpp"
#include "tools/oos/sweep_plan.hpp"
#include "tools/oos/sweep_results.hpp"
#include "tools/oos/verb.hpp"

namespace oos {
namespace {

constexpr double kMostSeeds = 10'000;

bench::Table PlanTable(const std::vector<GridAxis>& axes, const std::vector<SweepRun>& runs) {
  bench::Table table{"plan", {"run"}, {}};
  for (const GridAxis& axis : axes) table.columns.push_back(axis.name);
  table.columns.emplace_back("seed");
  for (const SweepRun& run : runs) {
    std::vector<std::string> row = {run.name};
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

// A run's folder appears whole or not at all.
core::Result<void> WriteRun(const scene::Scenario& scenario, const std::vector<GridAxis>& axes, const SweepRun& run,
                            const std::filesystem::path& folder) {
  std::error_code error;
  if (std::filesystem::exists(folder, error)) return {};
  const std::filesystem::path unfinished = folder.string() + ".unfinished";
  std::filesystem::remove_all(unfinished, error);
  if (auto copied = WriteScenarioCopy(scenario.file, axes, run.values, unfinished / "scenario"); !copied) {
    std::filesystem::remove_all(unfinished, error);
    return copied;
  }
  const std::string script =
      "#!/bin/sh\n# One run of a sweep. Exit status 0: the procedure was completed. $OOS: the program, when it is "
      "elsewhere.\ncd \"$(dirname \"$0\")\" || exit 2\nexec \"${OOS:-" +
      (ProgramFolder() / "oos").string() + "}\" run scenario/" + scenario.file.filename().string() +
      " --lockstep --seed " + std::to_string(run.seed) + " --out out > log.txt 2>&1\n";
  if (auto written = bench::WriteFile(unfinished / "run.sh", script); !written) return written;
  std::filesystem::permissions(unfinished / "run.sh", std::filesystem::perms::owner_all, error);
  std::filesystem::rename(unfinished, folder, error);
  if (error) return core::Fail(core::ErrorCode::kIo, "cannot make " + folder.string() + ": " + error.message());
  return {};
}

// A folder that has a plan already goes on where it stopped, if the plan is the same.
core::Result<void> WriteFolders(const scene::Scenario& scenario, const std::vector<GridAxis>& axes,
                                const std::vector<SweepRun>& runs, const std::filesystem::path& out) {
  std::error_code error;
  std::filesystem::create_directories(out / "runs", error);
  const std::string plan = bench::ToCsv(PlanTable(axes, runs));
  const std::filesystem::path file = out / "plan.csv";
  if (std::filesystem::exists(file, error) && ReadText(file) != plan) {
    return core::Fail(core::ErrorCode::kInvalidInput, out.string() + " holds another sweep (" + file.string() +
                                                          " differs); choose another --out, or remove it");
  }
  for (const SweepRun& run : runs) {
    if (auto written = WriteRun(scenario, axes, run, out / "runs" / run.name); !written) {
      return core::Fail(written.error().code, "run " + run.name + ": " + written.error().detail);
    }
  }
  return bench::WriteFile(file, plan);
}

// GNU parallel, which keeps the log of what has ended and leaves that out the next time. It gets Ctrl-C with this
// process. Returns false when it did not come to its end.
bool RunAll(const Arguments& arguments, const std::vector<SweepRun>& runs, const std::filesystem::path& out) {
  std::string names;
  for (const SweepRun& run : runs) names += "runs/" + run.name + "\n";
  if (!bench::WriteFile(out / "jobs.txt", names)) return false;
  std::vector<std::string> words = {"parallel", "--will-cite", "--joblog", "jobs.log",
                                    "--resume", "--arg-file",  "jobs.txt"};
  if (arguments.has("--jobs")) words.insert(words.end(), {"--jobs", arguments.text("--jobs")});
  if (arguments.has("--hosts")) {
    words.insert(words.end(), {"--sshlogin", arguments.text("--hosts"), "--workdir", "...", "--transferfile", "{}",
                               "--return", "{}/out", "--return", "{}/log.txt", "--cleanup", "--env", "OOS"});
  }
  words.emplace_back("{}/run.sh");
  const pid_t child = fork();
  if (child == 0) {
    if (chdir(out.c_str()) != 0) _exit(127);
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    execvp(pointers[0], pointers.data());
    std::fprintf(stderr, "oos sweep: GNU parallel is missing; install Debian's package 'parallel'\n");
    _exit(127);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  // Its exit status counts the runs that were not completed.
  return WIFEXITED(status) && WEXITSTATUS(status) < 127;
}

int Run(const Arguments& arguments) {
  const auto seeds = arguments.number("--seeds");
  if (!seeds) return Complain("sweep", seeds.error().detail, kBadUsage);
  const double num_seeds = seeds->value_or(1.0);
  if (num_seeds < 1.0 || num_seeds > kMostSeeds) return Complain("sweep", "--seeds is from 1 to 10000", kBadUsage);
  if (!arguments.has("--grid"))
    return Complain("sweep", "say what varies with --grid, see oos sweep --help", kBadUsage);
  std::vector<GridAxis> axes;
  for (const std::string& text : arguments.texts("--grid")) {
    auto axis = ParseAxis(text);
    if (!axis) return Complain("sweep", axis.error().detail, kBadUsage);
    axes.push_back(std::move(*axis));
  }
  const auto scenario = scene::LoadScenario(arguments.positional()[0]);
  if (!scenario) {
    for (const scene::Diagnostic& diagnostic : scenario.error()) {
      std::fprintf(stderr, "%s\n", scene::Format(diagnostic).c_str());
    }
    return kBadUsage;
  }
  const std::filesystem::path out = std::filesystem::absolute(arguments.text("--out", "out/sweep-" + scenario->name));
  const std::vector<SweepRun> runs = PlanRuns(axes, static_cast<unsigned>(num_seeds));
  if (auto written = WriteFolders(*scenario, axes, runs, out); !written) {
    return Complain("sweep", written.error().detail, kBadUsage);
  }
  std::printf("%zu runs in %s\n", runs.size(), (out / "runs").c_str());
  std::fflush(stdout);
  if (arguments.has("--dry-run")) return kHolds;
  if (!RunAll(arguments, runs, out)) {
    return Complain("sweep", "stopped before the end; the same command goes on from here", kDoesNotHold);
  }
  std::vector<SweepOutcome> outcomes;
  std::size_t num_reports = 0, num_completed = 0;
  for (const SweepRun& run : runs) {
    outcomes.push_back(ReadOutcome(out / "runs" / run.name));
    num_reports += outcomes.back().has_report ? 1 : 0;
    num_completed += outcomes.back().is_completed ? 1 : 0;
  }
  for (const auto& [name, text] : {std::pair{"results.csv", bench::ToCsv(ResultTable(axes, runs, outcomes))},
                                   std::pair{"results.svg", ResultChart(scenario->name, axes, runs, outcomes)}}) {
    if (auto written = bench::WriteFile(out / name, text); !written) {
      return Complain("sweep", written.error().detail, kDoesNotHold);
    }
  }
  std::printf("%zu of %zu runs completed their procedure: %s, %s\n", num_completed, runs.size(),
              (out / "results.csv").c_str(), (out / "results.svg").c_str());
  if (num_reports < runs.size()) {
    return Complain("sweep", std::to_string(runs.size() - num_reports) + " runs left no report; see their log.txt",
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
      {{"--grid", "NAME=LOW:HIGH:N", "what varies; or NAME=V,V,...; several make a grid"},
       {"--seeds", "N", "runs at each point, seeds 1 to N; default 1"},
       {"--out", "DIR", "default out/sweep-<scenario>"},
       {"--jobs", "N", "at the same time; default: one per core"},
       {"--hosts", "HOST,HOST", "run there over ssh; ':' is this one. $OOS names the program there"},
       {"--dry-run", "", "only writes the folders"}},
      Run,
      "NAME is an attribute of the scenario file: ATTRIBUTE (wherever it stands), ELEMENT.ATTRIBUTE or\n"
      "ELEMENT[NAME].ATTRIBUTE, e.g. --grid object[block].mass_kg=1:4:4 --grid run.method=paper,fast.\n"
      "DIR/runs/NNNNN is one run each, with all that it needs: run.sh is its one command (in lock-step, so as fast\n"
      "as the machine can), its exit status 0 when the procedure was completed. GNU parallel runs them; a cluster's\n"
      "scheduler can run them as an array as well. The same command again goes on with what had not ended.\n"
      "results.csv has a row per run, results.svg the means over the seeds. Exit status 0: every run has a report."};
}

}  // namespace oos
