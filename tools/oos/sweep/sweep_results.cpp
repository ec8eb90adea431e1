#include "tools/oos/sweep/sweep_results.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "tools/bench/chart.hpp"

namespace oos {
namespace {

// Sums over the seeds of one point of the grid.
struct Mean {
  int runs = 0, completed = 0;
  double seconds = 0.0, peak_force_N = 0.0;
};

// Position on the chart's axis: a number's value; words are at 0, 1, 2 ...
double PlaceOf(const GridAxis& axis, const std::string& value) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error == std::errc() && end == value.data() + value.size()) return number;
  return static_cast<double>(std::find(axis.values.begin(), axis.values.end(), value) - axis.values.begin());
}

double Number(const nlohmann::json& report, const char* key) {
  const auto it = report.find(key);
  return it != report.end() && it->is_number() ? it->get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::string Text(const nlohmann::json& report, const char* key) {
  const auto it = report.find(key);
  return it != report.end() && it->is_string() ? it->get<std::string>() : "";
}

}  // namespace

SweepOutcome ReadOutcome(const std::filesystem::path& run_folder) {
  std::ifstream in(run_folder / "out" / "report.json");
  const nlohmann::json report = nlohmann::json::parse(in, nullptr, false);
  SweepOutcome outcome;
  if (!report.is_object() || !report.contains("completed") || !report["completed"].is_boolean()) return outcome;
  outcome.is_completed = report["completed"].get<bool>();
  if (!outcome.is_completed) outcome.why = Text(report, "why");
  // The reason that `oos run` gives after SIGINT and SIGTERM: Ctrl-C, a killed sweep, or a scheduler's time limit.
  if (outcome.why == "interrupted") return {};
  outcome.has_report = true;
  outcome.seconds = Number(report, "seconds");
  outcome.peak_force_N = Number(report, "peak_force_N");
  return outcome;
}

bench::Table ResultTable(const std::vector<GridAxis>& axes, const std::vector<SweepRun>& runs,
                         const std::vector<SweepOutcome>& outcomes) {
  bench::Table table{"results", {"run"}, {}};
  for (const GridAxis& axis : axes) table.columns.push_back(axis.name);
  table.columns.insert(table.columns.end(), {"seed", "completed", "seconds", "peak_force_N", "why"});
  for (std::size_t i = 0; i < runs.size(); ++i) {
    std::vector<std::string> row = {runs[i].name};
    row.insert(row.end(), runs[i].values.begin(), runs[i].values.end());
    row.push_back(std::to_string(runs[i].seed));
    const SweepOutcome& outcome = outcomes[i];
    if (outcome.has_report) {
      row.insert(row.end(), {outcome.is_completed ? "1" : "0", bench::Cell(outcome.seconds),
                             bench::Cell(outcome.peak_force_N), outcome.why});
    } else {
      row.insert(row.end(), {"", "", "", "no report"});
    }
    table.Add(std::move(row));
  }
  return table;
}

std::string ResultChart(const std::string& scenario, const std::vector<GridAxis>& axes,
                        const std::vector<SweepRun>& runs, const std::vector<SweepOutcome>& outcomes) {
  std::map<std::string, std::map<double, Mean>> lines;  // by the other axes' values, then by the first one's
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!outcomes[i].has_report) continue;
    std::string line;
    for (std::size_t a = 1; a < axes.size(); ++a) {
      line += (a > 1 ? ", " : "") + axes[a].attribute + " " + runs[i].values[a];
    }
    const double x = axes.empty() ? runs[i].seed : PlaceOf(axes[0], runs[i].values[0]);
    Mean& mean = lines[line.empty() ? "mean" : line][x];
    ++mean.runs;
    mean.completed += outcomes[i].is_completed ? 1 : 0;
    mean.seconds += outcomes[i].seconds;
    mean.peak_force_N += outcomes[i].peak_force_N;
  }
  bench::Chart chart;
  chart.title = "Sweep of " + scenario;
  chart.subtitle = axes.empty() ? "each seed" : "means over the seeds";
  const auto add = [&](const char* title, const char* unit, auto value_of) {
    bench::Panel panel;
    panel.title = title;
    panel.x_title = axes.empty() ? "seed" : axes[0].name;
    panel.y_title = unit;
    panel.x_log = panel.y_log = false;
    for (const auto& [name, points] : lines) {
      bench::Series series;
      series.name = name;
      for (const auto& [x, mean] : points) {
        bench::ChartPoint point;
        point.x = x;
        point.y = value_of(mean);
        if (!std::isfinite(point.y)) continue;  // a report without this figure
        series.points.push_back(point);
      }
      panel.series.push_back(std::move(series));
    }
    chart.panels.push_back(std::move(panel));
  };
  add("Peak force", "N", [](const Mean& mean) { return mean.peak_force_N / mean.runs; });
  add("Time, simulated", "s", [](const Mean& mean) { return mean.seconds / mean.runs; });
  add("Completed", "% of the runs", [](const Mean& mean) { return 100.0 * mean.completed / mean.runs; });
  return bench::DrawSvg(chart);
}

}  // namespace oos
