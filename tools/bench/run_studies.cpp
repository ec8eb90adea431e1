#include "tools/bench/run_studies.hpp"

#include <algorithm>
#include <cstdio>
#include <sstream>

#include "core/clock.hpp"

namespace bench {
namespace {

core::Result<void> TryStudies(const BenchOptions& options, const Heading& heading, const std::vector<Study>& studies,
                              const std::string& missing_peer) {
  std::vector<std::string> known;
  for (const Study& study : studies) known.push_back(study.name);
  const auto only = ReadNames(options.only, known);
  if (!only) return tl::unexpected(only.error());
  if (const auto made = MakePlotFolder(options.plot); !made) return made;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  Report report;
  for (const Study& study : studies) {
    if (!only->empty() && std::find(only->begin(), only->end(), study.name) == only->end()) continue;
    std::printf("\n[%.0f s] %s\n", 1e-9 * static_cast<double>(core::MonotonicNow_ns() - begin_ns), study.name.c_str());
    study.run(&report);
  }
  if (!missing_peer.empty())
    report.skipped.push_back(missing_peer + ": not part of this program, `./dev bench` builds it in");
  for (const std::string& skipped : report.skipped) std::printf("skipped %s\n", skipped.c_str());
  report.tables.push_back(GoalTable(report.goals));
  PrintGoals(report.goals);
  return WriteReport(options.json, options.plot, heading, report);
}

}  // namespace

std::vector<std::string> SplitAtCommas(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, ',');) words.push_back(word);
  return words;
}

core::Result<std::vector<std::string>> ReadNames(const std::string& text, const std::vector<std::string>& known) {
  std::vector<std::string> names = SplitAtCommas(text);
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    std::string all;
    for (const std::string& one : known) all += " " + one;
    return core::Fail(core::ErrorCode::kInvalidInput, "no '" + name + "' to measure; known:" + all);
  }
  return names;
}

core::Result<void> MakePlotFolder(const std::filesystem::path& plot) {
  std::error_code error;
  if (!plot.empty() && !std::filesystem::create_directories(plot, error) && error) {
    return core::Fail(core::ErrorCode::kIo, plot.string() + ": cannot be made: " + error.message());
  }
  return {};
}

int RunStudies(const BenchOptions& options, const Heading& heading, const std::vector<Study>& studies,
               const std::string& missing_peer) {
  const auto done = TryStudies(options, heading, studies, missing_peer);
  if (done) return 0;
  std::fprintf(stderr, "oos bench: %s\n", done.error().detail.c_str());
  return 2;
}

}  // namespace bench
