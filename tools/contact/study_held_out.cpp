#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "bus/rt/worker_pool.hpp"
#include "core/clock.hpp"
#include "tools/contact/reference_poses.hpp"
#include "tools/contact/studies.hpp"
#include "vps/asset/choose_resolution.hpp"

namespace contact {
namespace {

// Not derived: more poses take longer, a third of a second each for their references.
constexpr int kPosesOfEachKind = 4;
constexpr int kPasses = 3;
constexpr double kSecondsEach = 0.1;  // of timing, for one contender on one case
constexpr double kAccuracies[] = {0.1, 0.05, 0.02, 0.01};
// Integral of depth of a contact that may be felt. A pair's force is stiffness * integral / max(A_c, rho A) (AreaScale
// in fast_pair_query.hpp), so at the default 2e4 N/m and with a hundredth of a part's 0.01 m^2 it is 2e-4 N; fingers
// feel some hundredths of a newton.
constexpr double kFelt_m3 = 1e-12;

// What is measured, in the order of the tables: `paper`, then `fast`, each with some numbers of points; then `fast` at
// each accuracy, with the voxels and points of UsualResolution.
struct Entrant {
  std::string method, setting, mark;
  const Contender* contender = nullptr;  // null: by accuracy
  double accuracy = 0.0;
};

// One pose of one entrant.
struct Sample {
  std::string family, kind, place;
  vps::CaseSet set = vps::CaseSet::kTraining;
  std::size_t entrant = 0;
  bool is_felt = false;
  vps::WrenchError error;
  bool is_missed = false;
  double estimate = std::numeric_limits<double>::quiet_NaN();  // of error.force; NaN: the method makes none
  bool is_reached = false;
  double places = 0.0;
  double time_us = 0.0;
};

std::vector<Entrant> EntrantsOf(const std::vector<Contender>& contenders) {
  std::vector<Entrant> entrants;
  for (const Contender& c : contenders) {
    if (!c.has_magnitude || (!c.mark.empty() && c.mark != "16k")) continue;
    entrants.push_back({c.method, c.setting, c.mark.empty() ? "65k" : c.mark, &c, 0.0});
  }
  for (const double accuracy : kAccuracies) {
    const std::string percent = Short(100.0 * accuracy) + " %";
    entrants.push_back({"fast", percent, percent, nullptr, accuracy});
  }
  return entrants;
}

// The same for thin parts and stout ones, so that a row compares shapes: voxels of 1/256 of A's longest side, and
// points on B one voxel apart.
Resolution UsualResolution(const vps::TriangleMesh& A, const vps::TriangleMesh& B) {
  const vps::Box box = vps::BoundingBox(A);
  const glm::dvec3 size = box.upper - box.lower;
  const double voxel_size_m = std::max({size.x, size.y, size.z}) / 256.0;
  return {voxel_size_m, vps::ChoosePoints(vps::SurfaceArea_m2(B), voxel_size_m)};
}

// Appends a sample for each entrant that can be built for these parts and each pose.
void Measure(const vps::WrenchCase& c, const std::vector<ReferencePose>& posed, const std::vector<Entrant>& entrants,
             std::vector<Sample>* samples) {
  const Resolution resolution = UsualResolution(c.A, c.B);
  const Parts parts{c.family + " " + c.name, c.A, c.B, resolution.voxel_size_m};
  const double radius_B_m = vps::RadiusAboutOrigin_m(c.B);
  Structures structures(parts);
  std::vector<Structures::Key> keys = {{false, vps::Method::kPaper, parts.voxel_size_m, 0}};
  for (const vps::Method kind : {vps::Method::kFast, vps::Method::kPaper}) {
    for (const std::uint32_t divisor : {1U, 4U}) keys.push_back({true, kind, 0.0, kMiddlePoints / divisor});
  }
  const Structures::Key field{false, vps::Method::kFast, parts.voxel_size_m, 0};
  const Structures::Key samples_of_B{true, vps::Method::kFast, 0.0, resolution.num_points};
  keys.insert(keys.end(), {field, samples_of_B});
  structures.Prepare(keys);
  const auto make = [&](const Entrant& entrant) -> core::Result<std::unique_ptr<Method>> {
    if (entrant.contender != nullptr) return entrant.contender->make(parts, structures);
    const auto A = structures.Get(field);
    if (!A) return tl::unexpected(A.error());
    const auto B = structures.Get(samples_of_B);
    if (!B) return tl::unexpected(B.error());
    return MakeFastMethod(*A, *B, {entrant.accuracy});
  };
  std::vector<std::unique_ptr<Method>> methods;
  std::vector<Racer> racers;
  std::vector<std::size_t> first;  // of each racer's samples
  for (std::size_t k = 0; k < entrants.size(); ++k) {
    auto method = make(entrants[k]);
    if (!method) {
      std::printf("  %s, %s left out of %s: %s\n", entrants[k].method.c_str(), entrants[k].setting.c_str(),
                  parts.name.c_str(), method.error().detail.c_str());
      continue;
    }
    first.push_back(samples->size());
    Racer racer;
    racer.method = method->get();
    for (const ReferencePose& p : posed) {
      const Answer answer = racer.method->Query(p.pose.X_AB);
      Sample sample;
      sample.family = c.family;
      sample.kind = ToText(p.pose.kind);
      sample.place = c.name + " " + sample.kind + " " + std::to_string(p.number);
      sample.set = c.set;
      sample.entrant = k;
      sample.is_felt = p.reference.depth_integral_m3 > kFelt_m3;
      sample.error = vps::CompareWrench(answer.force_A, answer.moment_A, p.reference, radius_B_m);
      sample.is_missed = answer.contacts == 0;
      if (answer.force_error) sample.estimate = *answer.force_error / p.reference.depth_integral_m3;
      sample.is_reached = answer.is_accurate;
      sample.places = static_cast<double>(answer.points_tested);
      samples->push_back(std::move(sample));
      racer.poses.push_back(p.pose.X_AB);
    }
    racers.push_back(std::move(racer));
    methods.push_back(std::move(*method));
  }
  Race(racers, kPasses, kSecondsEach);
  for (std::size_t r = 0; r < racers.size(); ++r) {
    for (std::size_t i = 0; i < posed.size(); ++i) (*samples)[first[r] + i].time_us = racers[r].by_pose_us[i];
  }
}

const std::vector<std::string> kFigures = {
    "poses",      "missed",     "force_p50",       "force_p99",         "force_max",         "worst_at",
    "moment_p50", "moment_p99", "moment_max",      "direction_p50_deg", "direction_p99_deg", "direction_max_deg",
    "p50_us",     "p99_us",     "within_estimate", "within_twice",      "reached",           "places_p50"};

// What a row is about, and its figures.
struct Row {
  std::string what;
  vps::CaseSet set = vps::CaseSet::kTraining;
  std::size_t entrant = 0;
  std::size_t num_poses = 0;
  double missed = 0.0;
  double force[3], moment[3], direction_deg[3];  // median, 99th percentile, worst
  std::string worst_at;
  double p50_us = 0.0, p99_us = 0.0;
  // Shares of poses at which the error of the force was within the estimate, and the estimate within what was asked
  // for; and the places that were read. NaN: the method makes no estimate.
  double within = 0.0, within_twice = 0.0, reached = 0.0, places = 0.0;
};

template <typename Wanted>
Row Summarize(const std::string& what, vps::CaseSet set, std::size_t entrant, const std::vector<Sample>& samples,
              const Wanted& is_wanted) {
  Row row;
  row.what = what;
  row.set = set;
  row.entrant = entrant;
  std::vector<double> force, moment, direction, us, places;
  double worst = -1.0;
  for (const Sample& s : samples) {
    if (s.set != set || s.entrant != entrant || !is_wanted(s)) continue;
    force.push_back(s.error.force);
    moment.push_back(s.error.moment);
    if (std::isfinite(s.error.direction_rad)) direction.push_back(glm::degrees(s.error.direction_rad));
    us.push_back(s.time_us);
    row.missed += s.is_missed ? 1.0 : 0.0;
    if (std::isfinite(s.estimate)) {
      row.within += s.error.force <= s.estimate ? 1.0 : 0.0;
      row.within_twice += s.error.force <= 2.0 * s.estimate ? 1.0 : 0.0;
      row.reached += s.is_reached ? 1.0 : 0.0;
      places.push_back(s.places);
    }
    if (s.error.force > worst) {
      worst = s.error.force;
      row.worst_at = (s.family == what ? "" : s.family + " ") + s.place;
    }
  }
  row.num_poses = force.size();
  row.missed /= static_cast<double>(std::max<std::size_t>(force.size(), 1));
  for (double* share : {&row.within, &row.within_twice, &row.reached}) {
    *share = places.empty() ? std::numeric_limits<double>::quiet_NaN() : *share / static_cast<double>(places.size());
  }
  row.places = Quantile(places, 0.5);
  const double shares[3] = {0.5, 0.99, 1.0};
  for (int i = 0; i < 3; ++i) {
    row.force[i] = Quantile(force, shares[i]);
    row.moment[i] = Quantile(moment, shares[i]);
    row.direction_deg[i] = Quantile(direction, shares[i]);
  }
  row.p50_us = Quantile(us, 0.5);
  row.p99_us = Quantile(us, 0.99);
  return row;
}

Table TableOf(const std::string& name, const std::string& what, const std::vector<Row>& rows,
              const std::vector<Entrant>& entrants) {
  Table table{name, {what, "set", "method", "setting"}, {}};
  table.columns.insert(table.columns.end(), kFigures.begin(), kFigures.end());
  for (const Row& r : rows) {
    if (r.num_poses == 0) continue;
    const Entrant& e = entrants[r.entrant];
    table.Add({r.what,
               std::string(ToText(r.set)),
               e.method,
               e.setting,
               std::to_string(r.num_poses),
               Cell(r.missed),
               Cell(r.force[0]),
               Cell(r.force[1]),
               Cell(r.force[2]),
               r.worst_at,
               Cell(r.moment[0]),
               Cell(r.moment[1]),
               Cell(r.moment[2]),
               Cell(r.direction_deg[0]),
               Cell(r.direction_deg[1]),
               Cell(r.direction_deg[2]),
               Cell(r.p50_us),
               Cell(r.p99_us),
               Cell(r.within),
               Cell(r.within_twice),
               Cell(r.reached),
               Cell(r.places)});
  }
  return table;
}

// Error against time over all families. Along a line: the accuracy asked for, or the number of points.
Chart ChartOf(const std::vector<Row>& rows, const std::vector<Entrant>& entrants) {
  Chart chart{"What an accuracy costs, on parts that constants were chosen on, and on others",
              "all families; marks: the accuracy asked for, or the number of points",
              {}};
  for (const vps::CaseSet set : vps::kCaseSets) {
    for (const int i : {0, 1}) {
      Panel panel;
      panel.title = set == vps::CaseSet::kTraining ? "Training set" : "Held-out set";
      panel.x_title = "time per query, median [us]";
      panel.y_title = i == 0 ? "error of force, median [%]" : "error of force, 99th percentile [%]";
      for (const Row& r : rows) {
        const Entrant& e = entrants[r.entrant];
        if (r.set != set || r.what != "all" || r.num_poses == 0) continue;
        auto series =
            std::find_if(panel.series.begin(), panel.series.end(), [&](const Series& s) { return s.name == e.method; });
        if (series == panel.series.end()) series = panel.series.insert(panel.series.end(), Series{e.method, {}, true});
        series->points.push_back({r.p50_us, 100.0 * r.force[i], e.mark});
      }
      chart.panels.push_back(std::move(panel));
    }
  }
  return chart;
}

void Print(const std::vector<Row>& rows, const std::vector<Entrant>& entrants) {
  std::printf("  %-12s %-9s %-7s %-16s %5s %7s %25s %25s %22s %9s %21s\n", "", "set", "method", "setting", "poses",
              "missed", "force % p50/p99/worst", "moment % p50/p99/worst", "direction deg", "p50 us",
              "within 1x/2x/reached");
  for (const Row& r : rows) {
    if (r.num_poses == 0) continue;
    const auto three = [](const double(&e)[3], double scale) {
      return Short(scale * e[0]) + " / " + Short(scale * e[1]) + " / " + Short(scale * e[2]);
    };
    const double shares[3] = {r.within, r.within_twice, r.reached};
    const Entrant& e = entrants[r.entrant];
    std::printf("  %-12s %-9s %-7s %-16s %5zu %7s %25s %25s %22s %9s %21s  %s\n", r.what.c_str(), ToText(r.set).data(),
                e.method.c_str(), e.setting.c_str(), r.num_poses, Short(r.missed).c_str(),
                three(r.force, 100.0).c_str(), three(r.moment, 100.0).c_str(), three(r.direction_deg, 1.0).c_str(),
                Short(r.p50_us).c_str(), three(shares, 1.0).c_str(), r.worst_at.c_str());
  }
  std::fflush(stdout);
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

// `rows`: over all of the held-out set, one for each entrant.
void Judge(const std::vector<Row>& rows, const std::vector<Entrant>& entrants, Report* report) {
  const Row* ten = nullptr;
  const Row* two = nullptr;
  for (const Row& r : rows) {
    const Entrant& e = entrants[r.entrant];
    const std::string where = "held-out parts, " + e.method + ", " + e.setting + ": ";
    if (r.num_poses == 0) continue;
    if (e.contender != nullptr && e.method != "paper") JudgeTwoPercent(where, r, report);
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
  report->AddGoal("held-out parts: median time at 10 % over that at 2 %", "<= 0.5", Short(ten->p50_us / two->p50_us),
                  ten->p50_us <= 0.5 * two->p50_us);
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
      for (const vps::WrenchCase& c : *cases) Measure(c, WithReferences(c, &num_without), entrants, &samples);
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
  std::vector<Row> families, kinds, judged;
  std::vector<std::string> names = vps::WrenchFamilies();
  names.insert(names.end(), {"felt", "all"});
  for (const vps::CaseSet set : vps::kCaseSets) {
    for (std::size_t k = 0; k < entrants.size(); ++k) {
      for (const std::string& name : names) {
        families.push_back(Summarize(name, set, k, samples, [&](const Sample& s) {
          return name == "all" || (name == "felt" ? s.is_felt : s.family == name);
        }));
      }
      if (set == vps::CaseSet::kHeldOut) judged.push_back(families.back());
      for (int kind = 0; kind < vps::kNumPoseKinds; ++kind) {
        const std::string name(ToText(static_cast<vps::PoseKind>(kind)));
        kinds.push_back(Summarize(name, set, k, samples, [&](const Sample& s) { return s.kind == name; }));
      }
    }
  }
  Judge(judged, entrants, report);
  std::printf("\nheldout: %d poses without a reference\n", num_without);
  Print(families, entrants);
  Print(kinds, entrants);
  report->tables.push_back(TableOf("heldout", "family", families, entrants));
  report->tables.push_back(TableOf("heldout_kinds", "kind", kinds, entrants));
  report->charts.emplace_back("heldout", ChartOf(families, entrants));
}

}  // namespace contact
