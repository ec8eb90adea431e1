// F6: a ball is drawn over an edge or a corner of a box. The device runs at a constant distance from the box, inside
// the ball's radius, so the exact direction is that from the nearest place of the box.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/failures/for_all.hpp"
#include "tools/failures/loop.hpp"
#include "tools/failures/prism.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kBox_m = 0.06;
constexpr double kRadius_m = 0.01;  // of the ball
constexpr double kDepth_m = 0.002;  // of the device
constexpr double kAlong_m = 0.012;  // of each flat part of the way
constexpr double kStep_m = 1e-4;

struct Trace {
  double flat_rad = 0.0;  // largest error farther than two voxels from the edge
  double step_rad = 0.0;  // largest change of direction from one cycle to the next
  Series direction, exact;
};

// The way in the plane of z and `out`, a unit vector across z: over the top, round the edge or the corner there, down
// the side or the corner's edge.
struct Way {
  std::string name;
  double edge_radius_m = 0.0;
  glm::dvec3 out{1.0, 0.0, 0.0};
  double across_m = 0.0003;  // along y: not over a line of the mesh
};

std::vector<Way> Ways() {
  return {{"an edge of 0 mm radius", 0.0},
          {"an edge of 0.1 mm radius", 1e-4},
          {"a sharp corner", 0.0, glm::normalize(glm::dvec3(1.0, 1.0, 0.0)), 0.0}};
}

Trace Draw(const Variant& variant, const Way& way) {
  const double edge_radius_m = way.edge_radius_m;
  SceneKit kit(variant);
  const auto box = kit.AddFixed(MakeRoundedBox({kBox_m, kBox_m, kBox_m}, edge_radius_m), {}, kVoxel_m);
  const double half = 0.5 * kBox_m;
  const double away = kRadius_m - kDepth_m;
  const double c = half - edge_radius_m;
  // The middle of the edge's arc: on its line x = z = c, or in the corner.
  const glm::dvec3 p_WE(c, way.out.y > 0.0 ? c : way.across_m, c);
  const glm::dvec3 up(0.0, 0.0, 1.0);
  const double flat = kAlong_m - edge_radius_m;
  const glm::dvec3 start = p_WE - flat * way.out + (edge_radius_m + kRadius_m + 0.001) * up;
  const auto ball = kit.AddHand(vps::MakeSphere(kRadius_m, 96), {{1, 0, 0, 0}, start}, kToolPoints);
  kit.AddPair(ball, box).friction = 0.0;
  Loop loop(kit.scenario);
  core::Pose X_WD = kit.device().X_WD_start;
  const double top = X_WD.translation.z;
  for (int i = 1; i <= 600; ++i) {  // down, and wait
    X_WD.translation.z = top + std::min(1.0, i / 300.0) * (half + away - top);
    loop.Tick(X_WD);
  }
  Trace trace;
  trace.direction = {variant.name, {}, true};
  trace.exact = {"exact", {}, true};
  const double r = edge_radius_m + away;  // of the way round the edge
  const double arc = 0.5 * std::numbers::pi * r;
  double before = 0.0;
  const int num_steps = static_cast<int>(std::ceil((2.0 * flat + arc) / kStep_m));
  for (int i = 0; i < num_steps; ++i) {
    const double s = kStep_m * i;
    const double angle = std::clamp((s - flat) / r, 0.0, 0.5 * std::numbers::pi);  // from z outwards
    const glm::dvec3 n = std::sin(angle) * way.out + std::cos(angle) * up;
    X_WD.translation = p_WE + r * n + std::min(0.0, s - flat) * way.out - std::max(0.0, s - flat - arc) * up;
    loop.Tick(X_WD);
    const glm::dvec3 F = loop.command().force_N;
    const double felt = std::atan2(glm::dot(F, way.out), F.z);
    if (s > 0.0) trace.step_rad = std::max(trace.step_rad, std::abs(felt - before));
    before = felt;
    const bool is_flat = s < flat - 2.0 * kVoxel_m || s > flat + arc + 2.0 * kVoxel_m;
    if (is_flat)
      trace.flat_rad = std::max(trace.flat_rad, std::acos(std::clamp(glm::dot(F, n) / glm::length(F), -1.0, 1.0)));
    trace.direction.points.push_back({1e3 * s, felt * 180.0 / M_PI, ""});
    trace.exact.points.push_back({1e3 * s, angle * 180.0 / M_PI, ""});
  }
  return trace;
}

}  // namespace

void StudyEdges(Report* report) {
  Chart chart{"F6: direction of the force over an edge and a corner",
              "ball of 10 mm, device 2 mm deep, 0.1 m/s, voxels of 1 mm",
              {}};
  Table table{"edges", {"contender", "over", "way_mm", "direction_deg", "exact_deg"}, {}};
  for (const Way& way : Ways()) {
    Panel panel;
    panel.title = way.name;
    panel.x_title = "way of the device [mm]";
    panel.y_title = "direction of the force [deg]";
    panel.x_log = panel.y_log = false;
    Row row{"F6",
            "sharp edges",
            "ball drawn over " + way.name + " at 0.1 m/s",
            "direction off beyond 2 voxels; largest step",
            "<= 5 deg; <= 10 deg",
            {},
            "`paper`: a depth is that of a layer of voxels, and its direction is one of a few"};
    const auto traces = OfVariants([&way](const Variant& variant) { return Draw(variant, way); });
    for (std::size_t v = 0; v < traces.size(); ++v) {
      const Variant& variant = Variants()[v];
      const Trace& trace = traces[v];
      if (panel.series.empty()) panel.series.push_back(trace.exact);
      panel.series.push_back(trace.direction);
      for (std::size_t i = 0; i < trace.exact.points.size(); ++i) {
        table.Add({variant.name, way.name, bench::Cell(trace.exact.points[i].x),
                   bench::Cell(trace.direction.points[i].y), bench::Cell(trace.exact.points[i].y)});
      }
      const double flat = trace.flat_rad * 180.0 / M_PI;
      const double step = trace.step_rad * 180.0 / M_PI;
      row.readings.push_back(
          {variant.name, Short(flat) + " deg; " + Short(step) + " deg", flat <= 5.0 && step <= 10.0});
    }
    chart.panels.push_back(panel);
    AddRow(report, row);
  }
  report->tables.push_back(table);
  report->charts.emplace_back("edges", chart);
}

}  // namespace failures
