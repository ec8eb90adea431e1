#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tools/contact/reference_poses.hpp"
#include "tools/contact/studies.hpp"

namespace contact {
namespace {

// Not derived: more poses take longer, a third of a second each for their references.
constexpr int kPosesOfEachKind = 4;
constexpr double kAccuracies[] = {0.3, 0.1, 0.05, 0.02, 0.01};
constexpr int kPasses = 3;
constexpr double kSecondsEach = 0.2;  // of timing, for one accuracy on one case

struct Sample {
  vps::CaseSet set = vps::CaseSet::kTraining;
  double accuracy = 0.0;
  std::string place;
  double force = 0.0;  // error, over the greater of the force and a tenth of the integral of depth
  double moment = 0.0;
  double estimate = 0.0;  // of `force`
  double places = 0.0;
  double time_us = 0.0;
};

// Sets *samples of one case at all accuracies.
void Measure(const vps::WrenchCase& c, const std::vector<ReferencePose>& posed, std::vector<Sample>* samples) {
  const double radius_B_m = vps::RadiusAboutOrigin_m(c.B);
  std::vector<std::unique_ptr<Method>> methods;
  std::vector<Racer> racers;
  std::vector<std::size_t> first;
  for (const double accuracy : kAccuracies) {
    auto method = MakeSurfaceMethod(c.A, c.B, {}, accuracy);
    if (!method) {
      std::printf("  left out %s %s: %s\n", c.family.c_str(), c.name.c_str(), method.error().detail.c_str());
      return;
    }
    first.push_back(samples->size());
    Racer racer;
    racer.method = method->get();
    for (const ReferencePose& p : posed) {
      const Answer answer = racer.method->Query(p.pose.X_AB);
      const vps::WrenchError error = vps::CompareWrench(answer.force_A, answer.moment_A, p.reference, radius_B_m);
      const double size = std::max(glm::length(p.reference.force_A_m3), 0.1 * p.reference.depth_integral_m3);
      const std::string place =
          c.family + " " + c.name + " " + std::string(ToText(p.pose.kind)) + " " + std::to_string(p.number);
      samples->push_back({c.set, accuracy, place, error.force, error.moment, *answer.force_error / size,
                          static_cast<double>(answer.points_tested), 0.0});
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

// Figures of a set at an accuracy. An estimate is reached when it is at most what was asked for: else the front of
// patches was full.
struct Row {
  vps::CaseSet set = vps::CaseSet::kTraining;
  double accuracy = 0.0;
  std::vector<double> force, moment, estimate, places, time_us;
  std::string worst_at;
  double within = 0.0, within_twice = 0.0, reached = 0.0;  // shares of poses

  [[nodiscard]] double share(double count) const {
    return count / static_cast<double>(std::max<std::size_t>(force.size(), 1));
  }
};

Row Summarize(vps::CaseSet set, double accuracy, const std::vector<Sample>& samples) {
  Row row{set, accuracy, {}, {}, {}, {}, {}, {}};
  double worst = -1.0;
  for (const Sample& s : samples) {
    if (s.set != set || s.accuracy != accuracy) continue;
    row.force.push_back(s.force);
    row.moment.push_back(s.moment);
    row.estimate.push_back(s.estimate);
    row.places.push_back(s.places);
    row.time_us.push_back(s.time_us);
    row.within += s.force <= s.estimate ? 1.0 : 0.0;
    row.within_twice += s.force <= 2.0 * s.estimate ? 1.0 : 0.0;
    // Asked for relative to the method's own force, which differs from the reference by its error.
    row.reached += s.estimate <= accuracy * (1.0 + s.force) ? 1.0 : 0.0;
    if (s.force > worst) {
      worst = s.force;
      row.worst_at = s.place;
    }
  }
  return row;
}

Table TableOf(const std::vector<Row>& rows) {
  Table table{
      "estimate",
      {"set", "accuracy", "poses", "force_p50", "force_p99", "force_max", "worst_at", "moment_p50", "moment_p99",
       "moment_max", "estimate_p50", "within_estimate", "within_twice", "reached", "places_p50", "p50_us", "p99_us"},
      {}};
  for (const Row& r : rows) {
    const auto q = [](const std::vector<double>& values, double share) { return Cell(Quantile(values, share)); };
    table.Add({std::string(ToText(r.set)), Cell(r.accuracy), std::to_string(r.force.size()), q(r.force, 0.5),
               q(r.force, 0.99), q(r.force, 1.0), r.worst_at, q(r.moment, 0.5), q(r.moment, 0.99), q(r.moment, 1.0),
               q(r.estimate, 0.5), Cell(r.share(r.within)), Cell(r.share(r.within_twice)), Cell(r.share(r.reached)),
               q(r.places, 0.5), q(r.time_us, 0.5), q(r.time_us, 0.99)});
  }
  return table;
}

// Error against time, the accuracy asked for along the line.
Chart ChartOf(const std::vector<Row>& rows) {
  Chart chart{"What an accuracy costs", "method surface, all families; marks: the accuracy asked for", {}};
  for (const vps::CaseSet set : vps::kCaseSets) {
    Panel panel;
    panel.title = set == vps::CaseSet::kTraining ? "Training set" : "Held-out set";
    panel.x_title = "time per query, median [us]";
    panel.y_title = "error of force [%]";
    for (const double share : {0.5, 0.99}) {
      Series series{share == 0.5 ? "median" : "99th percentile", {}, true};
      for (const Row& r : rows) {
        if (r.set != set || r.force.empty()) continue;
        series.points.push_back(
            {Quantile(r.time_us, 0.5), 100.0 * Quantile(r.force, share), Short(100.0 * r.accuracy) + " %"});
      }
      panel.series.push_back(std::move(series));
    }
    chart.panels.push_back(std::move(panel));
  }
  return chart;
}

void Judge(const Row& r, Report* report) {
  const std::string where = "held-out parts, surface, accuracy " + Short(100.0 * r.accuracy) + " %: ";
  const auto percent = [](double value) { return Short(100.0 * value) + " %"; };
  const double p99 = Quantile(r.force, 0.99);
  const double worst = Quantile(r.force, 1.0);
  if (r.accuracy == 0.02) {
    report->AddGoal(where + "force, 99th percentile, worst", "<= 2 %, <= 4 %", percent(p99) + ", " + percent(worst),
                    p99 <= 0.02 && worst <= 0.04);
    const double share = r.share(r.within_twice);
    report->AddGoal(where + "true error within twice its estimate", ">= 99.9 %", percent(share), share >= 0.999);
  }
  if (r.accuracy == 0.1) {
    report->AddGoal(where + "force, worst", "<= 15 %", percent(worst), worst <= 0.15);
  }
}

}  // namespace

void StudyEstimate(const Places& places, Report* report) {
  std::vector<Sample> samples;
  int num_without = 0;
  for (const std::string& family : vps::WrenchFamilies()) {
    for (const vps::CaseSet set : vps::kCaseSets) {
      const auto cases = vps::MakeWrenchCases(family, set, kPosesOfEachKind, places.meshes);
      if (!cases) {
        report->skipped.push_back("estimate " + family + ": " + cases.error().detail);
        std::printf("skipped %s\n", report->skipped.back().c_str());
        continue;
      }
      for (const vps::WrenchCase& c : *cases) Measure(c, WithReferences(c, &num_without), &samples);
      std::printf("  %s, %s: %zu cases\n", family.c_str(), ToText(set).data(), cases->size());
    }
  }
  std::vector<Row> rows;
  for (const vps::CaseSet set : vps::kCaseSets) {
    for (const double accuracy : kAccuracies) {
      rows.push_back(Summarize(set, accuracy, samples));
      const Row& r = rows.back();
      std::printf(
          "  %-9s %6s: %4zu poses, force %% p50/p99/worst %s / %s / %s (%s), within estimate %s, twice %s, %s us\n",
          ToText(set).data(), Short(accuracy).c_str(), r.force.size(), Short(100.0 * Quantile(r.force, 0.5)).c_str(),
          Short(100.0 * Quantile(r.force, 0.99)).c_str(), Short(100.0 * Quantile(r.force, 1.0)).c_str(),
          r.worst_at.c_str(), Short(r.share(r.within)).c_str(), Short(r.share(r.within_twice)).c_str(),
          Short(Quantile(r.time_us, 0.5)).c_str());
      if (set == vps::CaseSet::kHeldOut) Judge(r, report);
    }
  }
  std::printf("estimate: %d poses without a reference\n", num_without);
  report->tables.push_back(TableOf(rows));
  report->charts.emplace_back("estimate", ChartOf(rows));
}

}  // namespace contact
