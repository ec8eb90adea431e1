#include "tools/contact/accuracy_race.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tools/contact/stopwatch.hpp"
#include "tools/contact/workload.hpp"
#include "vps/asset/choose_resolution.hpp"

namespace contact {
namespace {

constexpr int kPasses = 3;
constexpr double kSecondsEach = 0.1;  // of timing, for one contender on one case
const std::vector<std::string> kFigures = {
    "poses",      "missed",     "force_p50",       "force_p99",         "force_max",         "worst_at",
    "moment_p50", "moment_p99", "moment_max",      "direction_p50_deg", "direction_p99_deg", "direction_max_deg",
    "p50_us",     "p99_us",     "within_estimate", "within_twice",      "reached",           "places_p50"};

}  // namespace

Resolution UsualResolution(const vps::TriangleMesh& A, const vps::TriangleMesh& B) {
  const vps::Box box = vps::BoundingBox(A);
  const glm::dvec3 size = box.upper - box.lower;
  const double voxel_size_m = std::max({size.x, size.y, size.z}) / 256.0;
  return {voxel_size_m, vps::ChoosePoints(vps::SurfaceArea_m2(B), voxel_size_m)};
}

Entrant FastEntrant(const FastGoal& goal) {
  const std::string percent = Short(100.0 * goal.accuracy) + " %";
  const auto make = [goal](const Parts& parts, const Resolution& resolution,
                           Structures* structures) -> core::Result<std::unique_ptr<Method>> {
    const auto A = structures->Get({false, vps::Method::kFast, parts.voxel_size_m, 0});
    if (!A) return tl::unexpected(A.error());
    const auto B = structures->Get({true, vps::Method::kFast, 0.0, resolution.num_points});
    if (!B) return tl::unexpected(B.error());
    return MakeFastMethod(*A, *B, goal);
  };
  return {"fast", percent, percent, make, goal.accuracy};
}

void Measure(const vps::WrenchCase& c, const Resolution& resolution, const std::vector<ReferencePose>& posed,
             const std::vector<Entrant>& entrants, const std::vector<Structures::Key>& keys,
             const std::function<bool(const ReferencePose&)>& is_felt, std::vector<Sample>* samples) {
  const Parts parts{c.family + " " + c.name, c.A, c.B, resolution.voxel_size_m};
  const double radius_B_m = vps::RadiusAboutOrigin_m(c.B);
  Structures structures(parts);
  structures.Prepare(keys);
  std::vector<std::unique_ptr<Method>> methods;
  std::vector<Racer> racers;
  std::vector<std::size_t> first;  // of each racer's samples
  for (std::size_t k = 0; k < entrants.size(); ++k) {
    auto method = entrants[k].make(parts, resolution, &structures);
    if (!method) {
      std::printf("  %s, %s left out of %s: %s\n", entrants[k].method.c_str(), entrants[k].setting.c_str(),
                  parts.name.c_str(), method.error().detail.c_str());
      continue;
    }
    first.push_back(samples->size());
    Racer racer;
    racer.method = method->get();
    for (const ReferencePose& p : posed) {
      for (int i = 1; i < entrants[k].queries; ++i) racer.method->Query(p.pose.X_AB);
      const Answer answer = racer.method->Query(p.pose.X_AB);
      Sample sample;
      sample.family = c.family;
      sample.kind = ToText(p.pose.kind);
      sample.place = c.name + " " + sample.kind + " " + std::to_string(p.number);
      sample.set = c.set;
      sample.entrant = k;
      sample.is_felt = is_felt(p);
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

Row Summarize(const std::string& what, vps::CaseSet set, std::size_t entrant, const std::vector<Sample>& samples,
              const std::function<bool(const Sample&)>& is_wanted) {
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

Panel ErrorPanel(const std::string& title, int share, const std::string& what, vps::CaseSet set,
                 const std::vector<Row>& rows, const std::vector<Entrant>& entrants) {
  Panel panel;
  panel.title = title;
  panel.x_title = "time per query, median [us]";
  panel.y_title = share == 0 ? "error of force, median [%]" : "error of force, 99th percentile [%]";
  for (const Row& r : rows) {
    const Entrant& e = entrants[r.entrant];
    if (r.set != set || r.what != what || r.num_poses == 0) continue;
    auto series =
        std::find_if(panel.series.begin(), panel.series.end(), [&](const Series& s) { return s.name == e.method; });
    if (series == panel.series.end()) series = panel.series.insert(panel.series.end(), Series{e.method, {}, true});
    series->points.push_back({r.p50_us, 100.0 * r.force[share], e.mark});
  }
  return panel;
}

}  // namespace contact
