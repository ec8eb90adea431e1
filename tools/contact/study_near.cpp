#include <algorithm>
#include <cstdio>

#include "tools/contact/studies.hpp"
#include "vps/oracle/body_distance.hpp"

namespace contact {
namespace {

// Not derived: length of a run against scatter of the medians.
constexpr int kPasses = 5;
constexpr double kSecondsEach = 1.0;
constexpr std::size_t kCompared = 16;  // poses with an exact distance, which takes up to a fifth of a second
constexpr double kWanted_us = 300.0;

struct NearPoses {
  const char* kind;
  std::vector<core::Pose> poses;
  Times times{};
};

// The first poses of every walk: the peg's queries take tens of milliseconds.
std::vector<core::Pose> Beginnings(const Workload& workload) {
  constexpr std::size_t kSteps = 25;
  std::vector<core::Pose> poses;
  for (const auto& walk : workload.walks) {
    const std::size_t count = std::min(kSteps, walk.size());
    poses.insert(poses.end(), walk.begin(), walk.begin() + static_cast<std::ptrdiff_t>(count));
  }
  return poses;
}

// Distances of some of the poses against the exact ones.
struct Looseness {
  std::vector<double> gaps_m, shares;  // the latter: (exact - answer) / exact
  std::size_t num_false = 0;           // contacts where there is a gap
};

Looseness CompareDistances(const Parts& parts, const std::vector<core::Pose>& poses, Method* method) {
  const vps::oracle::MeshDistance A(parts.A);
  const vps::oracle::MeshDistance B(parts.B);
  Looseness out;
  const std::size_t step = std::max<std::size_t>(poses.size() / kCompared, 1);
  for (std::size_t i = 0; i < poses.size(); i += step) {
    const Answer answer = method->Query(poses[i]);
    const double gap_m = vps::oracle::SurfaceDistance(A, B, poses[i]);
    out.num_false += answer.contacts > 0 && gap_m > 0.0 ? 1 : 0;
    out.gaps_m.push_back(gap_m);
    if (gap_m > 0.0 && answer.contacts == 0) out.shares.push_back((gap_m - answer.signed_distance_m) / gap_m);
  }
  return out;
}

void MeasureNear(const Parts& parts, const Workload& workload, Method* method, Table* table, Report* report) {
  std::vector<NearPoses> sets = {{"consecutive", Beginnings(workload)}, {"independent", workload.independent}};
  std::vector<Racer> racers;
  for (const NearPoses& set : sets) racers.push_back({method, set.poses, true, {}});
  Race(racers, kPasses, kSecondsEach);
  for (std::size_t i = 0; i < sets.size(); ++i) {
    sets[i].times = racers[i].times;
    const Times& t = sets[i].times;
    const Looseness looseness = CompareDistances(parts, sets[i].poses, method);
    table->Add({workload.name, sets[i].kind, std::to_string(sets[i].poses.size()),
                Cell(Quantile(looseness.gaps_m, 0.5)), Cell(t.p50_us), Cell(t.p99_us), Cell(t.max_us),
                Cell(Quantile(looseness.shares, 0.5)), Cell(Quantile(looseness.shares, 1.0)),
                std::to_string(looseness.num_false)});
    std::printf("near, %s, %s: %s us median, %s us 99th percentile; gap %s mm, bound below it by %s %% (worst %s %%)\n",
                workload.name.c_str(), sets[i].kind, Short(t.p50_us).c_str(), Short(t.p99_us).c_str(),
                Short(1e3 * Quantile(looseness.gaps_m, 0.5)).c_str(),
                Short(100.0 * Quantile(looseness.shares, 0.5)).c_str(),
                Short(100.0 * Quantile(looseness.shares, 1.0)).c_str());
  }
  report->AddGoal("bodies near but apart (" + workload.name + "), `oos query`: median time of a query", "<= 300 us",
                  Short(sets[0].times.p50_us) + " us consecutive, " + Short(sets[1].times.p50_us) + " us independent",
                  sets[0].times.p50_us <= kWanted_us && sets[1].times.p50_us <= kWanted_us);
}

}  // namespace

void StudyNear(const PartsSource& parts, Report* report) {
  Table table{"near",
              {"workload", "poses", "count", "gap_p50_m", "p50_us", "p99_us", "max_us", "bound_below_p50",
               "bound_below_max", "false_contacts"},
              {}};
  for (const char* name : {"bunnies", "peg"}) {
    const core::Result<PartsAndWorkloads>& made = parts(name);
    if (!made) {
      report->skipped.push_back(std::string("near, ") + name + ": " + made.error().detail);
      continue;
    }
    const auto method = MakeFastMethod(made->parts->A, made->parts->B, {made->parts->voxel_size_m, kMiddlePoints});
    if (!method) continue;
    for (const Workload& w : made->workloads) {
      if (w.fit == Fit::kNear || w.fit == Fit::kApart) MeasureNear(*made->parts, w, method->get(), &table, report);
    }
  }
  report->tables.push_back(table);
}

}  // namespace contact
