#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tools/contact/reference_poses.hpp"
#include "tools/contact/studies.hpp"

namespace contact {
namespace {

// Not derived: more poses take longer, a third of a second each for their references.
constexpr int kPosesOfEachKind = 6;
constexpr int kPasses = 5;
constexpr double kSecondsEach = 0.3;  // of timing, for one contender on one case

// One pose of one contender.
struct Sample {
  std::string family, kind, place;
  vps::CaseSet set = vps::CaseSet::kTraining;
  std::size_t contender = 0;
  vps::WrenchError error;
  bool is_missed = false;
  double time_us = 0.0;
};

// Appends a sample for each contender that can be built for these parts and each pose.
void Measure(const vps::WrenchCase& c, const std::vector<ReferencePose>& posed,
             const std::vector<Contender>& contenders, std::vector<Sample>* samples) {
  const Parts parts{c.family + " " + c.name, c.A, c.B, ResolveResolution(c.A, c.B, {}).voxel_size_m};
  const double radius_B_m = vps::RadiusAboutOrigin_m(c.B);
  Structures structures(parts);
  std::vector<Structures::Key> keys;
  for (const vps::Method kind : {vps::Method::kFast, vps::Method::kPaper}) {
    keys.push_back({false, kind, parts.voxel_size_m, 0});
    for (const std::uint32_t divisor : {1U, 4U}) keys.push_back({true, kind, 0.0, kMiddlePoints / divisor});
  }
  structures.Prepare(keys);
  std::vector<std::unique_ptr<Method>> methods;
  std::vector<Racer> racers;
  std::vector<std::size_t> first;  // of each racer's samples
  for (std::size_t k = 0; k < contenders.size(); ++k) {
    auto method = contenders[k].make(parts, structures);
    if (!method) {
      std::printf("  %s, %s left out of %s: %s\n", contenders[k].method.c_str(), contenders[k].setting.c_str(),
                  parts.name.c_str(), method.error().detail.c_str());
      continue;
    }
    first.push_back(samples->size());
    Racer racer;
    racer.method = method->get();
    for (const ReferencePose& p : posed) {
      const Answer answer = racer.method->Query(p.pose.X_AB);
      Sample sample{c.family, std::string(ToText(p.pose.kind)), {}, c.set, k, {}, answer.contacts == 0, 0.0};
      sample.place = c.name + " " + sample.kind + " " + std::to_string(p.number);
      sample.error = vps::CompareWrench(answer.force_A, answer.moment_A, p.reference, radius_B_m);
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
    "poses",      "missed",     "force_p50",         "force_p99",         "force_max",         "worst_at", "moment_p50",
    "moment_p99", "moment_max", "direction_p50_deg", "direction_p99_deg", "direction_max_deg", "p50_us",   "p99_us"};

// What a row is about, and its figures.
struct Row {
  std::string what;
  vps::CaseSet set = vps::CaseSet::kTraining;
  std::size_t contender = 0;
  std::size_t num_poses = 0;
  double missed = 0.0;
  double force[3], moment[3], direction_deg[3];  // median, 99th percentile, worst
  std::string worst_at;
  double p50_us = 0.0, p99_us = 0.0;
};

template <typename Wanted>
Row Summarize(const std::string& what, vps::CaseSet set, std::size_t contender, const std::vector<Sample>& samples,
              const Wanted& is_wanted) {
  Row row;
  row.what = what;
  row.set = set;
  row.contender = contender;
  std::vector<double> force, moment, direction, us;
  double worst = -1.0;
  for (const Sample& s : samples) {
    if (s.set != set || s.contender != contender || !is_wanted(s)) continue;
    force.push_back(s.error.force);
    moment.push_back(s.error.moment);
    if (std::isfinite(s.error.direction_rad)) direction.push_back(glm::degrees(s.error.direction_rad));
    us.push_back(s.time_us);
    row.missed += s.is_missed ? 1.0 : 0.0;
    if (s.error.force > worst) {
      worst = s.error.force;
      row.worst_at = (s.family == what ? "" : s.family + " ") + s.place;
    }
  }
  row.num_poses = force.size();
  row.missed /= static_cast<double>(std::max<std::size_t>(force.size(), 1));
  const double shares[3] = {0.5, 0.99, 1.0};
  for (int i = 0; i < 3; ++i) {
    row.force[i] = bench::Quantile(force, shares[i]);
    row.moment[i] = bench::Quantile(moment, shares[i]);
    row.direction_deg[i] = bench::Quantile(direction, shares[i]);
  }
  row.p50_us = bench::Quantile(us, 0.5);
  row.p99_us = bench::Quantile(us, 0.99);
  return row;
}

Table TableOf(const std::string& name, const std::string& what, const std::vector<Row>& rows,
              const std::vector<Contender>& contenders) {
  Table table{name, {what, "set", "method", "setting"}, {}};
  table.columns.insert(table.columns.end(), kFigures.begin(), kFigures.end());
  for (const Row& r : rows) {
    if (r.num_poses == 0) continue;
    const Contender& c = contenders[r.contender];
    table.Add({r.what, std::string(ToText(r.set)), c.method, c.setting, std::to_string(r.num_poses), Cell(r.missed),
               Cell(r.force[0]), Cell(r.force[1]), Cell(r.force[2]), r.worst_at, Cell(r.moment[0]), Cell(r.moment[1]),
               Cell(r.moment[2]), Cell(r.direction_deg[0]), Cell(r.direction_deg[1]), Cell(r.direction_deg[2]),
               Cell(r.p50_us), Cell(r.p99_us)});
  }
  return table;
}

// Error against time at the middle resolution; a mark is a family.
Chart ChartOf(const std::vector<Row>& rows, const std::vector<Contender>& contenders) {
  Chart chart{
      "Parts that constants were chosen on, and others", "one mark for each family of parts; s, 65,536 points", {}};
  for (const vps::CaseSet set : vps::kCaseSets) {
    for (const int i : {0, 1}) {
      Panel panel;
      panel.title = set == vps::CaseSet::kTraining ? "Training set" : "Held-out set";
      panel.x_title = "time per query, median [us]";
      panel.y_title = i == 0 ? "error of force, median [%]" : "error of force, 99th percentile [%]";
      for (const Row& r : rows) {
        const Contender& c = contenders[r.contender];
        if (r.set != set || !c.mark.empty() || r.what == "all" || r.num_poses == 0) continue;
        auto series =
            std::find_if(panel.series.begin(), panel.series.end(), [&](const Series& s) { return s.name == c.method; });
        if (series == panel.series.end()) series = panel.series.insert(panel.series.end(), Series{c.method, {}, false});
        series->points.push_back({r.p50_us, 100.0 * r.force[i], r.what});
      }
      chart.panels.push_back(std::move(panel));
    }
  }
  return chart;
}

void Print(const std::vector<Row>& rows, const std::vector<Contender>& contenders) {
  std::printf("  %-12s %-9s %-7s %-16s %5s %7s %25s %25s %22s %9s\n", "", "set", "method", "setting", "poses", "missed",
              "force % p50/p99/worst", "moment % p50/p99/worst", "direction deg", "p50 us");
  for (const Row& r : rows) {
    if (r.num_poses == 0) continue;
    const auto three = [](const double(&e)[3], double scale) {
      return Short(scale * e[0]) + " / " + Short(scale * e[1]) + " / " + Short(scale * e[2]);
    };
    const Contender& c = contenders[r.contender];
    std::printf("  %-12s %-9s %-7s %-16s %5zu %7s %25s %25s %22s %9s  %s\n", r.what.c_str(), ToText(r.set).data(),
                c.method.c_str(), c.setting.c_str(), r.num_poses, Short(r.missed).c_str(),
                three(r.force, 100.0).c_str(), three(r.moment, 100.0).c_str(), three(r.direction_deg, 1.0).c_str(),
                Short(r.p50_us).c_str(), r.worst_at.c_str());
  }
}

void Judge(const Row& r, const Contender& c, Report* report) {
  const auto text = [](const double(&e)[3]) { return Short(100.0 * e[1]) + " %, " + Short(100.0 * e[2]) + " % worst"; };
  const std::string where = "held-out parts, " + c.method + ", " + c.setting + ": ";
  report->AddGoal(where + "force, 99th percentile, worst", "<= 2 %, <= 4 %", text(r.force),
                  r.force[1] <= 0.02 && r.force[2] <= 0.04);
  report->AddGoal(where + "moment, 99th percentile, worst", "<= 2 %, <= 4 %", text(r.moment),
                  r.moment[1] <= 0.02 && r.moment[2] <= 0.04);
}

}  // namespace

void StudyHeldOut(const std::vector<Contender>& all, const Places& places, Report* report) {
  std::vector<Contender> contenders;
  for (const Contender& c : all) {
    if (c.has_magnitude && (c.mark.empty() || c.mark == "16k")) contenders.push_back(c);
  }
  std::vector<Sample> samples;
  int num_without = 0;
  for (const std::string& family : vps::WrenchFamilies()) {
    for (const vps::CaseSet set : vps::kCaseSets) {
      const auto cases = vps::MakeWrenchCases(family, set, kPosesOfEachKind, places.meshes);
      if (!cases) {
        report->skipped.push_back("heldout " + family + ": " + cases.error().detail);
        std::printf("skipped %s\n", report->skipped.back().c_str());
        continue;
      }
      for (const vps::WrenchCase& c : *cases) Measure(c, WithReferences(c, &num_without), contenders, &samples);
      // So that a run that is stopped was not for nothing.
      std::vector<Row> rows;
      for (std::size_t k = 0; k < contenders.size(); ++k) {
        rows.push_back(
            Summarize(family, set, k, samples, [&](const Sample& sample) { return sample.family == family; }));
      }
      Print(rows, contenders);
    }
  }
  std::vector<Row> families, kinds;
  std::vector<std::string> names = vps::WrenchFamilies();
  names.push_back("all");
  for (const vps::CaseSet set : vps::kCaseSets) {
    for (std::size_t k = 0; k < contenders.size(); ++k) {
      for (const std::string& name : names) {
        families.push_back(
            Summarize(name, set, k, samples, [&](const Sample& s) { return name == "all" || s.family == name; }));
      }
      for (int kind = 0; kind < vps::kNumPoseKinds; ++kind) {
        const std::string name(ToText(static_cast<vps::PoseKind>(kind)));
        kinds.push_back(Summarize(name, set, k, samples, [&](const Sample& s) { return s.kind == name; }));
      }
      if (set == vps::CaseSet::kHeldOut && contenders[k].method != "paper") {
        Judge(families.back(), contenders[k], report);
      }
    }
  }
  std::printf("\nheldout: %d poses without a reference\n", num_without);
  Print(families, contenders);
  Print(kinds, contenders);
  report->tables.push_back(TableOf("heldout", "family", families, contenders));
  report->tables.push_back(TableOf("heldout_kinds", "kind", kinds, contenders));
  report->charts.emplace_back("heldout", ChartOf(families, contenders));
}

}  // namespace contact
