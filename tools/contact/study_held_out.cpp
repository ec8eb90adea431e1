#include <algorithm>
#include <cstdio>

#include "bus/rt/worker_pool.hpp"
#include "core/clock.hpp"
#include "tools/contact/accuracy_race.hpp"
#include "tools/contact/studies.hpp"

namespace contact {
namespace {

// Not derived: more poses take longer, a third of a second each for their references.
constexpr int kPosesOfEachKind = 4;
// Integral of depth of a contact that may be felt. A pair's force is stiffness * integral / max(A_c, rho A) (AreaScale
// in fast_pair_query.hpp), so at the default 2e4 N/m and with a hundredth of a part's 0.01 m^2 it is 2e-4 N; fingers
// feel some hundredths of a newton.
constexpr double kFelt_m3 = 1e-12;
constexpr double kAccuracies[] = {0.1, 0.05, 0.02, 0.01};

bool IsFelt(const ReferencePose& pose) {
  return pose.reference.depth_integral_m3 > kFelt_m3;
}

// In the order of the tables: `paper`, then `fast`, each with some numbers of points; then `fast` at each accuracy,
// with the voxels and points of UsualResolution.
std::vector<Entrant> EntrantsOf(const std::vector<Contender>& contenders) {
  std::vector<Entrant> entrants;
  for (const Contender& c : contenders) {
    if (!c.has_magnitude || (!c.mark.empty() && c.mark != "16k")) continue;
    entrants.push_back({c.method, c.setting, c.mark.empty() ? "65k" : c.mark,
                        [make = c.make](const Parts& parts, const Resolution&, Structures* structures) {
                          return make(parts, *structures);
                        }});
  }
  for (const double accuracy : kAccuracies) entrants.push_back(FastEntrant({accuracy}));
  return entrants;
}

std::vector<Structures::Key> KeysOf(const Resolution& resolution) {
  std::vector<Structures::Key> keys = {{false, vps::Method::kPaper, resolution.voxel_size_m, 0}};
  for (const vps::Method kind : {vps::Method::kFast, vps::Method::kPaper}) {
    for (const std::uint32_t divisor : {1U, 4U}) keys.push_back({true, kind, 0.0, kMiddlePoints / divisor});
  }
  keys.push_back({false, vps::Method::kFast, resolution.voxel_size_m, 0});
  keys.push_back({true, vps::Method::kFast, 0.0, resolution.num_points});
  return keys;
}

Chart ChartOf(const std::vector<Row>& rows, const std::vector<Entrant>& entrants) {
  Chart chart{"What an accuracy costs, on parts that constants were chosen on, and on others",
              "contacts that may be felt, all families; marks: the accuracy asked for, or the number of points",
              {}};
  for (const vps::CaseSet set : vps::kCaseSets) {
    const std::string title = set == vps::CaseSet::kTraining ? "Training set" : "Held-out set";
    for (const int share : {0, 1}) chart.panels.push_back(ErrorPanel(title, share, "felt", set, rows, entrants));
  }
  return chart;
}

std::string Percent(double share) {
  return Short(100.0 * share) + " %";
}

void JudgeTwoPercent(const std::string& where, const Row& r, Report* report) {
  const auto text = [](const double(&e)[3]) { return Percent(e[1]) + ", " + Percent(e[2]) + " worst"; };
  report->AddGoal(where + "force, 99th percentile, worst", "<= 2 %, <= 4 %", text(r.force),
                  r.force[1] <= 0.02 && r.force[2] <= 0.04);
  report->AddGoal(where + "moment, 99th percentile, worst", "<= 2 %, <= 4 %", text(r.moment),
                  r.moment[1] <= 0.02 && r.moment[2] <= 0.04);
}

// `rows`: over the held-out set, all of it or what may be felt, one for each entrant.
void Judge(const std::vector<Row>& rows, const std::vector<Entrant>& entrants, Report* report) {
  const Row* ten = nullptr;
  const Row* two = nullptr;
  for (const Row& r : rows) {
    const Entrant& e = entrants[r.entrant];
    const std::string where = "held-out parts, " + r.what + ", " + e.method + ", " + e.setting + ": ";
    if (r.num_poses == 0) continue;
    if (e.accuracy == 0.0 && e.method != "paper") JudgeTwoPercent(where, r, report);
    if (e.accuracy == 0.02) {
      two = &r;
      JudgeTwoPercent(where, r, report);
      report->AddGoal(where + "true error within twice its estimate", ">= 99.9 %", Percent(r.within_twice),
                      r.within_twice >= 0.999);
    }
    if (e.accuracy == 0.1) {
      ten = &r;
      report->AddGoal(where + "force, moment, worst", "<= 15 %", Percent(r.force[2]) + ", " + Percent(r.moment[2]),
                      r.force[2] <= 0.15 && r.moment[2] <= 0.15);
    }
  }
  if (ten == nullptr || two == nullptr) return;
  report->AddGoal("held-out parts, " + two->what + ": median time at 10 % over that at 2 %", "<= 0.5",
                  Short(ten->p50_us / two->p50_us), ten->p50_us <= 0.5 * two->p50_us);
}

// A family's cases of both sets, made side by side: most of the time goes into finding poses.
std::vector<core::Result<std::vector<vps::WrenchCase>>> CasesOf(const std::string& family,
                                                                const std::filesystem::path& public_meshes) {
  struct Job {
    const std::string& family;
    const std::filesystem::path& meshes;
    std::vector<core::Result<std::vector<vps::WrenchCase>>> cases;
  } job{family, public_meshes, {}};
  job.cases.resize(std::size(vps::kCaseSets));
  bus::WorkerPool workers(2, "poses");
  workers.Run(
      job.cases.size(),
      [](void* context, std::size_t i) {
        Job& todo = *static_cast<Job*>(context);
        todo.cases[i] = vps::MakeWrenchCases(todo.family, vps::kCaseSets[i], kPosesOfEachKind, todo.meshes);
      },
      &job);
  return std::move(job.cases);
}

}  // namespace

void StudyHeldOut(const std::vector<Contender>& contenders, const Places& places, Report* report) {
  const std::vector<Entrant> entrants = EntrantsOf(contenders);
  std::vector<Sample> samples;
  int num_without = 0;
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  for (const std::string& family : vps::WrenchFamilies()) {
    for (const auto& cases : CasesOf(family, places.meshes)) {
      if (!cases) {
        report->skipped.push_back("heldout " + family + ": " + cases.error().detail);
        std::printf("skipped %s\n", report->skipped.back().c_str());
        continue;
      }
      for (const vps::WrenchCase& c : *cases) {
        const Resolution resolution = UsualResolution(c.A, c.B);
        Measure(c, resolution, WithReferences(c, &num_without), entrants, KeysOf(resolution), IsFelt, &samples);
      }
      // So that a run that is stopped was not for nothing.
      std::vector<Row> rows;
      for (std::size_t k = 0; k < entrants.size() && !cases->empty(); ++k) {
        rows.push_back(Summarize(family, cases->front().set, k, samples,
                                 [&](const Sample& sample) { return sample.family == family; }));
      }
      std::printf("[%.0f s of heldout]\n", 1e-9 * static_cast<double>(core::MonotonicNow_ns() - begin_ns));
      Print(rows, entrants);
    }
  }
  std::vector<Row> families, kinds, all, felt;
  std::vector<std::string> names = vps::WrenchFamilies();
  names.insert(names.end(), {"felt", "all"});
  for (const vps::CaseSet set : vps::kCaseSets) {
    for (std::size_t k = 0; k < entrants.size(); ++k) {
      for (const std::string& name : names) {
        families.push_back(Summarize(name, set, k, samples, [&](const Sample& s) {
          return name == "all" || (name == "felt" ? s.is_felt : s.family == name);
        }));
      }
      if (set == vps::CaseSet::kHeldOut) {
        all.push_back(families.back());
        felt.push_back(families[families.size() - 2]);
      }
      for (int kind = 0; kind < vps::kNumPoseKinds; ++kind) {
        const std::string name(ToText(static_cast<vps::PoseKind>(kind)));
        kinds.push_back(Summarize(name, set, k, samples, [&](const Sample& s) { return s.kind == name; }));
      }
    }
  }
  for (const auto& judged : {all, felt}) Judge(judged, entrants, report);
  std::printf("\nheldout: %d poses without a reference\n", num_without);
  Print(families, entrants);
  Print(kinds, entrants);
  report->tables.push_back(TableOf("heldout", "family", families, entrants));
  report->tables.push_back(TableOf("heldout_kinds", "kind", kinds, entrants));
  report->charts.emplace_back("heldout", ChartOf(families, entrants));
}

}  // namespace contact
