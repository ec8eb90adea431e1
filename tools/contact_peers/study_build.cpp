#include "tools/contact_peers/study_build.hpp"

#include <cstdio>

#include "tools/contact_peers/build_comparison.hpp"

namespace contact_peers {

void StudyBuild(const contact::Places& places, contact::Report* report) {
  using contact::Cell;
  using contact::Short;
  const auto builds = CompareBuilds(places.meshes);
  if (!builds) {
    report->skipped.push_back("build: " + builds.error().detail);
    return;
  }
  contact::Table table{"build", {"mesh", "method", "voxels", "threads", "time_s", "stored_bytes", "peak_bytes"}, {}};
  contact::Chart chart{
      "Building the field", "voxels along the longest side, band of 3 voxels, 2 threads: time, and memory", {}};
  const auto find = [&](const BuildMeasurement& of, const char* method) {
    for (const BuildMeasurement& b : *builds) {
      if (b.mesh == of.mesh && b.voxels == of.voxels && b.threads == of.threads && b.method == method) return &b;
    }
    return &of;
  };
  double slowest = 1e30, peak = 0.0, stored = 0.0;
  std::string slowest_at, peak_at, stored_at;
  for (const BuildMeasurement& b : *builds) {
    table.Add({b.mesh, b.method, std::to_string(b.voxels), std::to_string(b.threads), Cell(b.time_s),
               Cell(b.stored_bytes), Cell(b.peak_bytes)});
    const BuildMeasurement& vdb = *find(b, "OpenVDB");
    if (b.method != "fast" || &vdb == &b) continue;
    const std::string at = b.mesh + ", " + std::to_string(b.voxels);
    if (vdb.time_s / b.time_s < slowest) {
      slowest = vdb.time_s / b.time_s;
      slowest_at = at + ", threads: " + std::to_string(b.threads);
    }
    if (b.peak_bytes / b.stored_bytes > peak) {
      peak = b.peak_bytes / b.stored_bytes;
      peak_at = at;
    }
    if (b.stored_bytes / vdb.stored_bytes > stored) {
      stored = b.stored_bytes / vdb.stored_bytes;
      stored_at = at;
    }
    if (b.threads != 2) continue;
    contact::Panel time, memory;
    time.title = at + " voxels: time";
    time.x_title = "s";
    memory.title = at + " voxels: memory";
    memory.x_title = "MB";
    time.x_log = memory.x_log = false;
    for (const BuildMeasurement* m : {&b, &vdb}) {
      time.bars.push_back({m->method, m->time_s, Short(m->time_s), m->method});
      memory.bars.push_back({m->method + ", stored", 1e-6 * m->stored_bytes, Short(1e-6 * m->stored_bytes), m->method});
      memory.bars.push_back({m->method + ", peak", 1e-6 * m->peak_bytes, Short(1e-6 * m->peak_bytes), m->method});
    }
    chart.panels.push_back(time);
    chart.panels.push_back(memory);
  }
  report->tables.push_back(table);
  report->charts.emplace_back("build", chart);
  report->AddGoal("build at 256 and 512 voxels against OpenVDB, worst of all", ">= 2 x faster",
                  Short(slowest) + " x (" + slowest_at + ")", slowest >= 2.0);
  report->AddGoal("build: peak memory over stored, worst of all", "<= 3", Short(peak) + " (" + peak_at + ")",
                  peak <= 3.0);
  report->AddGoal("build: stored memory over OpenVDB's, worst of all", "<= 1", Short(stored) + " (" + stored_at + ")",
                  stored <= 1.0);
}

}  // namespace contact_peers
