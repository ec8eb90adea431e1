#include "tools/transport/bench.hpp"

#include <algorithm>
#include <cstdio>
#include <sstream>

#include "core/clock.hpp"
#include "tools/transport/studies.hpp"

namespace transport {
namespace {

struct Study {
  const char* name;
  void (*run)(const Setting&, Report*);
};
constexpr Study kStudies[] = {
    {"hop", StudyHop}, {"classes", StudyClasses}, {"age", StudyAge}, {"load", StudyLoad}, {"bulk", StudyBulk}};

std::vector<std::string> SplitAtCommas(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, ',');) words.push_back(word);
  return words;
}

core::Result<void> RunBench(const BenchOptions& options, const std::vector<Peer>& peers) {
  std::error_code error;
  if (!options.plot.empty() && !std::filesystem::create_directories(options.plot, error) && error) {
    return core::Fail(core::ErrorCode::kIo, options.plot.string() + ": cannot be made: " + error.message());
  }
  const std::vector<std::string> only = SplitAtCommas(options.only);
  for (const std::string& name : only) {
    if (std::any_of(std::begin(kStudies), std::end(kStudies), [&](const Study& s) { return name == s.name; })) continue;
    std::string names;
    for (const Study& study : kStudies) names += std::string(" ") + study.name;
    return core::Fail(core::ErrorCode::kInvalidInput, "no '" + name + "' to measure; known:" + names);
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  Report report;
  for (const Study& study : kStudies) {
    if (!only.empty() && std::find(only.begin(), only.end(), study.name) == only.end()) continue;
    std::printf("\n[%.0f s] %s\n", 1e-9 * static_cast<double>(core::MonotonicNow_ns() - begin_ns), study.name);
    study.run({peers, options.effort}, &report);
  }
  if (peers.empty()) report.skipped.emplace_back("LCM: not part of this program, `./dev bench` builds it in");
  for (const std::string& skipped : report.skipped) std::printf("skipped %s\n", skipped.c_str());
  report.tables.push_back(bench::GoalTable(report.goals));
  bench::PrintGoals(report.goals);
  return bench::WriteReport(options.json, options.plot, {"bus", "Goals of the bus, measured", bench::ProcessorText()},
                            report);
}

}  // namespace

int BenchMain(const BenchOptions& options, const std::vector<Peer>& peers) {
  const auto done = RunBench(options, peers);
  if (done) return 0;
  std::fprintf(stderr, "oos bench: %s\n", done.error().detail.c_str());
  return 2;
}

}  // namespace transport
