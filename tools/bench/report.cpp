#include "tools/bench/report.hpp"

#include <cstdio>
#include <fstream>

namespace bench {
namespace {

std::string GoalPage(const Heading& heading, const std::vector<Goal>& goals) {
  std::string page = "# " + heading.title + "\n\nWritten by `oos bench " + heading.bench + "`. " + heading.machine +
                     ".\n\n| what | wanted | measured | met |\n|---|---|---|---|\n";
  for (const Goal& g : goals) {
    page += "| " + g.what + " | " + g.wanted + " | " + g.measured + " | " + ToText(g.verdict) + " |\n";
  }
  return page;
}

}  // namespace

const char* ToText(Verdict verdict) {
  switch (verdict) {
    case Verdict::kMet:
      return "yes";
    case Verdict::kPartly:
      return "partly";
    case Verdict::kMissed:
      return "no";
    default:
      return "not measured";
  }
}

Table GoalTable(const std::vector<Goal>& goals) {
  Table table{"goals", {"what", "wanted", "measured", "met"}, {}};
  for (const Goal& g : goals) table.Add({g.what, g.wanted, g.measured, ToText(g.verdict)});
  return table;
}

std::string ProcessorText() {
  std::ifstream stream("/proc/cpuinfo");
  std::string line;
  std::string processor = "unknown processor";
  while (std::getline(stream, line)) {
    if (line.rfind("model name", 0) == 0) {
      processor = line.substr(line.find(':') + 2);
      break;
    }
  }
  return processor + ", one core; GCC " __VERSION__;
}

void PrintGoals(const std::vector<Goal>& goals) {
  std::printf("\n%-74s %-22s %-58s %s\n", "what", "wanted", "measured", "met");
  for (const Goal& g : goals) {
    std::printf("%-74s %-22s %-58s %s\n", g.what.c_str(), g.wanted.c_str(), g.measured.c_str(), ToText(g.verdict));
  }
}

core::Result<void> WriteReport(const std::filesystem::path& json, const std::filesystem::path& plot,
                               const Heading& heading, const Report& report) {
  if (!plot.empty()) {
    for (const Table& table : report.tables) {
      if (auto done = WriteFile(plot / (table.name + ".csv"), ToCsv(table)); !done) return done;
    }
    for (const auto& [name, chart] : report.charts) {
      if (auto done = WriteFile(plot / (name + ".svg"), DrawSvg(chart)); !done) return done;
    }
    if (auto done = WriteFile(plot / "goals.md", GoalPage(heading, report.goals)); !done) return done;
  }
  if (json.empty()) return {};
  std::string text = "{\n  \"bench\": " + QuoteJson(heading.bench) + ",\n  \"machine\": " + QuoteJson(heading.machine) +
                     ",\n  \"skipped\": [";
  for (std::size_t i = 0; i < report.skipped.size(); ++i) text += (i ? ", " : "") + QuoteJson(report.skipped[i]);
  text += "]";
  for (const Table& table : report.tables) text += ",\n  " + QuoteJson(table.name) + ": " + ToJson(table, "  ");
  return WriteFile(json, text + "\n}\n");
}

}  // namespace bench
