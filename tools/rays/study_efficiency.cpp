#include <filesystem>
#include <string>

#include "tiles/testing/emulation.hpp"
#include "tools/rays/studies.hpp"

namespace rays {
namespace {

// A message's way through the bus and two threads that wait for it; what a worker needs for a tile beside its pixels.
// As in libs/tiles/schedule_test.cpp.
constexpr double kMessage_s = 0.5e-3, kPerTile_s = 30e-6;
constexpr std::size_t kWarm = 20, kFrames = 100;
constexpr double kWanted = 0.92;
// Twelve GPUs were "almost four times" as fast as one [Berthold 2013, the thesis behind VR-OOS's ray tracer].
constexpr double kPublished = 4.0 / 12.0;

struct Busy {
  double frames_per_s = 0.0;
  double efficiency = 0.0;  // ideal over real time: the work of the pixels alone, spread over all without a gap
};

Busy Run(const tiles::RecordedCosts& costs, std::size_t workers) {
  tiles::Emulation emulation(&costs, workers, kMessage_s, kPerTile_s);
  emulation.RunFrames(kWarm);
  const double begin_s = emulation.now_s();
  emulation.RunFrames(kFrames);
  const double took_s = emulation.now_s() - begin_s;
  double pixels_s = 0.0;
  for (std::size_t frame = kWarm + 1; frame <= kWarm + kFrames; ++frame) {
    pixels_s += costs.Of(frame, {0, 0, costs.width, costs.height});
  }
  return {static_cast<double>(kFrames) / took_s, pixels_s / static_cast<double>(workers) / took_s};
}

}  // namespace

void StudyEfficiency(bench::Report* report) {
  const auto file = std::filesystem::path(VR_OOS_SOURCE_DIR) / "libs/tiles/testing/recorded_costs.txt";
  const auto costs = tiles::RecordedCosts::Read(file);
  if (costs.frames.empty()) {
    report->skipped.push_back("efficiency: " + file.string() + " is missing; it is in the sources");
    return;
  }
  bench::Table table{"efficiency", {"workers", "frames_per_s", "efficiency"}, {}};
  bench::Series busy{"tiles by measured cost", {}}, ideal{"ideal", {}};
  bench::Series published{"published: 12 GPUs", {{12.0, kPublished, "a third"}}, false};
  for (const std::size_t workers : {1, 2, 3, 4, 6, 8, 10, 12, 14, 16}) {
    const Busy run = Run(costs, workers);
    const auto x = static_cast<double>(workers);
    table.Add({bench::Cell(x), bench::Cell(run.frames_per_s), bench::Cell(run.efficiency)});
    busy.points.push_back({x, run.efficiency, ""});
    ideal.points.push_back({x, 1.0, ""});
    if (workers == 12) {
      report->AddGoal("12 emulated workers with recorded costs, efficiency against ideal", ">= 0.92",
                      bench::Short(run.efficiency), run.efficiency >= kWanted);
    }
  }
  report->tables.push_back(std::move(table));
  bench::Panel panel;
  panel.x_title = "workers";
  panel.y_title = "share of ideal";
  panel.series = {busy, ideal, published};
  panel.x_log = panel.y_log = false;
  panel.y_low = 0.0;
  panel.y_high = 1.1;
  report->charts.emplace_back(
      "efficiency",
      bench::Chart{
          "How busy workers are", "1280x720 of module_replacement; tiles' costs recorded with one worker", {panel}});
}

}  // namespace rays
