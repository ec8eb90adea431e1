#include "tools/oos/run/report/report_charts.hpp"

#include "tools/bench/chart.hpp"

namespace oos {
namespace {

void AddPanel(const char* title, const char* y_title, const std::vector<Course>& courses, bench::Chart* chart) {
  bench::Panel panel;
  panel.title = title;
  panel.x_title = "simulated time, s";
  panel.y_title = y_title;
  panel.x_log = panel.y_log = false;
  panel.y_low = 0.0;
  for (const Course& course : courses) {
    bench::Series series{course.name, {}};
    for (const Course::Point& point : course.points) series.points.push_back({point.t_s, point.value, ""});
    if (!series.points.empty()) panel.series.push_back(std::move(series));
  }
  if (!panel.series.empty()) chart->panels.push_back(std::move(panel));
}

}  // namespace

std::string DrawHistory(const RunHistory& history) {
  bench::Chart chart;
  chart.title = "Over the run";
  chart.subtitle = "Force and latency: the highest value of each of 400 equal intervals.";
  AddPanel("Force on the hand", "N", history.force_N, &chart);
  AddPanel("Latency (t1: hand to hand, t2_image: hand to picture)", "ms", history.latency_ms, &chart);
  AddPanel("Late haptic cycles since the start", "cycles", {history.late_cycles}, &chart);
  return chart.panels.empty() ? "" : bench::DrawSvg(chart);
}

}  // namespace oos
