#include "tools/contact/bench.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>

#include "core/clock.hpp"
#include "tools/bench/run_studies.hpp"
#include "tools/contact/studies.hpp"
#include "vps/walk/field_walk.hpp"

namespace contact {
namespace {

std::string MachineText() {
  const vps::InstructionSet set = vps::BestInstructionSet();
  const char* const name = set == vps::InstructionSet::kAvx512 ? "AVX-512"
                           : set == vps::InstructionSet::kAvx2 ? "AVX2"
                                                               : "portable";
  return bench::ProcessorText() + "; walk: " + name;
}

// Keeps, of the CSV file that the table will replace, the rows of parts that were not measured this time. The first
// cell of a row names the parts.
void KeepOtherRows(const std::filesystem::path& folder, Table* table) {
  std::ifstream file(folder / (table->name + ".csv"));
  std::string line;
  std::vector<std::vector<std::string>> kept;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::vector<std::string> row = bench::SplitAtCommas(line);
    row.resize(table->columns.size());
    const bool is_measured =
        std::any_of(table->rows.begin(), table->rows.end(), [&](const auto& r) { return r[0] == row[0]; });
    if (!is_measured) kept.push_back(row);
  }
  table->rows.insert(table->rows.begin(), kept.begin(), kept.end());
}

struct Figures {
  std::vector<Measurement> contests;
  std::vector<PointScaling> points;
  std::vector<KernelFigures> kernels;
  std::vector<FieldFigures> fields;
};

// Runs all measurements that share these parts' fields and samples.
void MeasureParts(const PartsAndWorkloads& made, const std::vector<Contender>& contenders, Figures* figures,
                  Report* report) {
  Structures structures(*made.parts);
  const Team team = MakeTeam(*made.parts, contenders, &structures);
  for (const Workload& workload : made.workloads) {
    const std::vector<Measurement> rows = Contest(*made.parts, workload, team);
    PrintContest(workload, rows);
    report->tables.push_back(ContestTable(workload.name, rows));
    const Chart chart = ContestChart(workload, rows);
    if (!chart.panels.empty()) report->charts.emplace_back(workload.name, chart);
    figures->contests.insert(figures->contests.end(), rows.begin(), rows.end());
    if (workload.fit != Fit::kApart) figures->kernels.push_back(StudyKernel(workload, *made.parts, &structures));
  }
  const std::vector<FieldFigures> fields = StudyField(made, &structures);
  figures->fields.insert(figures->fields.end(), fields.begin(), fields.end());
  for (const Workload& workload : made.workloads) {
    if (workload.name != "peg_pressed" && workload.name != "nut_pressed" && workload.name != "bunny_light" &&
        workload.name != "bunny_near") {
      continue;
    }
    const auto rows = StudyPoints(workload, *made.parts, &structures);
    figures->points.insert(figures->points.end(), rows.begin(), rows.end());
  }
}

}  // namespace

core::Result<void> RunBench(const BenchOptions& options, const Peers& peers) {
  if (const auto made = bench::MakePlotFolder(options.plot); !made) return made;
  std::vector<std::string> known = PartsNames();
  known.insert(known.end(), {"heldout", "training", "scenes", "near", "steps", "slide", "flat", "free_peg", "scene",
                             "reads", "cook", "build"});
  const auto only = bench::ReadNames(options.only, known);
  if (!only) return tl::unexpected(only.error());
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const auto is_wanted = [&](const std::string& name) {
    return only->empty() || std::find(only->begin(), only->end(), name) != only->end();
  };
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  const auto print_progress = [&](const std::string& what) {
    std::printf("\n[%.0f s] %s\n", 1e-9 * static_cast<double>(core::MonotonicNow_ns() - begin_ns), what.c_str());
  };
  std::vector<Contender> contenders = OwnContenders();
  contenders.insert(contenders.end(), peers.contenders.begin(), peers.contenders.end());
  // The search for the poses takes seconds: made once for all studies.
  std::map<std::string, core::Result<PartsAndWorkloads>> made_before;
  const PartsSource parts = [&](const std::string& name) -> const core::Result<PartsAndWorkloads>& {
    const auto at = made_before.find(name);
    return at != made_before.end() ? at->second
                                   : made_before.emplace(name, MakeParts(name, options.places)).first->second;
  };
  Figures figures;
  Report report;
  for (const std::string& name : PartsNames()) {
    if (!is_wanted(name)) continue;
    print_progress(name);
    const core::Result<PartsAndWorkloads>& made = parts(name);
    if (!made) {
      report.skipped.push_back(name + ": " + made.error().detail);
      std::printf("skipped %s\n", report.skipped.back().c_str());
      continue;
    }
    MeasureParts(*made, contenders, &figures, &report);
  }
  JudgeContests(figures.contests, &report);
  ReportPoints(figures.points, &report);
  ReportKernels(figures.kernels, &report);
  ReportFields(figures.fields, &report);
  ReportWrenches(figures.contests, &report);
  if (is_wanted("heldout")) {
    print_progress("heldout");
    StudyHeldOut(contenders, options.places, &report);
  }
  if (!only->empty() && is_wanted("training")) {
    print_progress("training");
    StudyTraining(options.plot, &report);
  }
  if (is_wanted("scenes")) {
    print_progress("scenes");
    StudyScenePairs(options.places, &report);
  }
  if (is_wanted("near")) {
    print_progress("near");
    StudyNear(parts, &report);
  }
  if (is_wanted("steps")) {
    print_progress("steps");
    StudySteps(parts, options.places, &report);
  }
  const std::vector<std::pair<const char*, void (*)(Report*)>> studies = {{"slide", StudySlide},
                                                                          {"flat", StudyFlat},
                                                                          {"free_peg", StudyFreePeg},
                                                                          {"scene", StudyScene},
                                                                          {"reads", StudyReads}};
  for (const auto& [name, study] : studies) {
    if (!is_wanted(name)) continue;
    print_progress(name);
    study(&report);
  }
  if (is_wanted("cook")) {
    print_progress("cook");
    StudyCook(options.places, &report);
  }
  if (peers.study_build && is_wanted("build")) peers.study_build(options.places, &report);
  if (!options.plot.empty()) {
    for (Table& table : report.tables) {
      if (table.name == "field_accuracy" || table.name == "wrench_accuracy") KeepOtherRows(options.plot, &table);
    }
  }
  report.tables.push_back(bench::GoalTable(report.goals));
  bench::PrintGoals(report.goals);
  print_progress("done");
  return bench::WriteReport(options.json, options.plot, {"vps", "Goals of contact queries, measured", MachineText()},
                            report);
}

int BenchMain(const BenchOptions& options, const Peers& peers) {
  const auto done = RunBench(options, peers);
  if (done) return 0;
  std::fprintf(stderr, "oos bench: %s\n", done.error().detail.c_str());
  return 2;
}

}  // namespace contact
