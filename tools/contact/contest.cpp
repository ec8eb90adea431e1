#include "tools/contact/contest.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/clock.hpp"
#include "tools/contact/truth.hpp"

namespace contact {
namespace {

// Not derived: they trade the length of a whole run against the scatter of the medians.
constexpr int kPasses = 5;
constexpr double kSecondsEach = 0.35;        // for one contender on one kind of poses
constexpr double kSecondsOfTheMiddle = 1.0;  // at the middle resolution, whose ratios the goals use
// Lower end of the logarithmic axes, in each panel's unit. Not derived; differences so small are the exact answers'
// own.
constexpr double kLeastError = 1e-4;

double AngleDeg(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180.0 / 3.14159265358979323846;
}

Errors Summary(const std::vector<double>& errors) {
  return {Quantile(errors, 0.5), Quantile(errors, 0.95), Quantile(errors, 1.0)};
}

}  // namespace

void Compare(const Parts& parts, const Workload& workload, const std::vector<Answer>& truth, bool has_magnitude,
             Method* method, Measurement* m) {
  double radius = 0.0;
  for (const glm::dvec3& v : parts.B.vertices) radius = std::max(radius, glm::length(v));
  std::vector<double> direction, magnitude, torque, depth;
  double tested = 0.0;
  int missed = 0;
  int touching = 0;
  method->Forget();  // errors do not depend on what was timed before
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Answer answer = method->Query(workload.independent[i]);
    tested += static_cast<double>(answer.points_tested);
    m->forces.push_back(glm::length(answer.force_A));
    m->contacts.push_back(answer.contacts);
    const Answer& exact = truth[i];
    const double f = glm::length(exact.force_A);
    if (!(f > 0.0)) continue;
    ++touching;
    if (answer.contacts == 0) {
      ++missed;
      continue;
    }
    if (answer.signed_distance_m < 0.0) depth.push_back(std::abs(answer.signed_distance_m - exact.signed_distance_m));
    if (!(glm::length(answer.force_A) > 0.0)) continue;
    direction.push_back(AngleDeg(answer.force_A, exact.force_A));
    if (!has_magnitude) continue;
    magnitude.push_back(std::abs(glm::length(answer.force_A) / f - 1.0));
    torque.push_back(glm::length(answer.moment_A - exact.moment_A) / (f * radius));
  }
  m->direction_deg = Summary(direction);
  m->magnitude = Summary(magnitude);
  m->torque = Summary(torque);
  m->depth_m = Summary(depth);
  m->missed = touching > 0 ? static_cast<double>(missed) / touching : std::numeric_limits<double>::quiet_NaN();
  m->points_tested = tested / static_cast<double>(std::max<std::size_t>(truth.size(), 1));
}

namespace {

// The first n poses of every walk, n = seconds / (passes times time per query times number of walks), at least two.
std::vector<core::Pose> Shortened(const Workload& workload, double query_s, double seconds) {
  std::vector<core::Pose> poses;
  const double wanted = seconds / (kPasses * std::max(query_s, 1e-9) * static_cast<double>(workload.walks.size()));
  for (const auto& walk : workload.walks) {
    const auto count = static_cast<std::size_t>(std::clamp(wanted, 2.0, static_cast<double>(walk.size())));
    poses.insert(poses.end(), walk.begin(), walk.begin() + static_cast<std::ptrdiff_t>(count));
  }
  return poses;
}

Contender Own(const char* method, const char* setting, const char* mark, double factor, std::uint32_t num_points,
              double accuracy = kAccuracy) {
  const vps::Method kind = std::string(method) == "fast" ? vps::Method::kFast : vps::Method::kPaper;
  Contender c;
  c.method = method;
  c.setting = setting;
  c.mark = mark;
  c.make = [=](const Parts& parts, Structures& structures) -> core::Result<std::unique_ptr<Method>> {
    const auto A = structures.Get({false, kind, factor * parts.voxel_size_m, 0});
    if (!A) return tl::unexpected(A.error());
    const auto B = structures.Get({true, kind, 0.0, num_points});
    if (!B) return tl::unexpected(B.error());
    if (kind == vps::Method::kPaper) return MakePaperMethod(*A, *B, vps::SurfaceArea_m2(parts.B), true);
    return MakeFastMethod(*A, *B, InContests(accuracy));
  };
  return c;
}

}  // namespace

std::vector<Contender> OwnContenders() {
  std::vector<Contender> all;
  for (const char* method : {"paper", "fast"}) {
    all.push_back(Own(method, kMiddle, "", 1.0, kMiddlePoints));
    all.push_back(Own(method, "2 s; 65536 points", "2s", 2.0, kMiddlePoints));
    all.push_back(Own(method, "s/2; 65536 points", "s/2", 0.5, kMiddlePoints));
    all.push_back(Own(method, "s; 16384 points", "16k", 1.0, kMiddlePoints / 4));
    all.push_back(Own(method, "s; 4096 points", "4k", 1.0, kMiddlePoints / 16));
  }
  all.push_back(Own("fast", kMiddleAtTen, "10 %", 1.0, kMiddlePoints, 0.1));
  return all;
}

Team MakeTeam(const Parts& parts, const std::vector<Contender>& contenders, Structures* structures) {
  std::vector<Structures::Key> keys;
  for (const vps::Method kind : {vps::Method::kFast, vps::Method::kPaper}) {
    for (const double factor : {0.5, 1.0, 2.0}) keys.push_back({false, kind, factor * parts.voxel_size_m, 0});
    for (const std::uint32_t divisor : {1U, 4U, 16U}) keys.push_back({true, kind, 0.0, kMiddlePoints / divisor});
  }
  structures->Prepare(keys);
  Team team;
  for (const Contender& contender : contenders) {
    auto method = contender.make(parts, *structures);
    if (!method) {
      std::printf("  %s, %s left out: %s\n", contender.method.c_str(), contender.setting.c_str(),
                  method.error().detail.c_str());
      continue;
    }
    team.contenders.push_back(&contender);
    team.methods.push_back(std::move(*method));
  }
  return team;
}

std::vector<Measurement> Contest(const Parts& parts, const Workload& workload, const Team& team) {
  const bool is_touching = workload.fit != Fit::kNear && workload.fit != Fit::kApart;
  const std::vector<Answer> truth =
      is_touching ? ExactAnswers(parts, workload) : std::vector<Answer>(workload.independent.size());
  std::vector<Measurement> rows(team.methods.size());
  std::vector<Racer> consecutive(rows.size());
  std::vector<Racer> independent(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Contender& contender = *team.contenders[i];
    Method* const method = team.methods[i].get();
    rows[i].workload = workload.name;
    rows[i].method = contender.method;
    rows[i].setting = contender.setting;
    rows[i].mark = contender.mark;
    const std::int64_t start_ns = core::MonotonicNow_ns();
    Compare(parts, workload, truth, contender.has_magnitude, method, &rows[i]);
    const double query_s = 1e-9 * static_cast<double>(core::MonotonicNow_ns() - start_ns) /
                           static_cast<double>(workload.independent.size());
    const bool is_middle = contender.mark.empty();
    consecutive[i] = {method,
                      Shortened(workload, query_s, is_middle ? kSecondsOfTheMiddle : kSecondsEach),
                      workload.fit != Fit::kApart,
                      {}};
    independent[i] = {method, workload.independent, workload.fit != Fit::kApart, {}};
  }
  Race(consecutive, kPasses, kSecondsOfTheMiddle);
  Race(independent, kPasses, kSecondsEach);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].consecutive = consecutive[i].times;
    rows[i].independent = independent[i].times;
  }
  return rows;
}

Table ContestTable(const std::string& name, const std::vector<Measurement>& rows) {
  Table table{name, {"workload", "method", "setting"}, {}};
  for (const char* kind : {"consecutive", "independent"}) {
    for (const char* what : {"p50_us", "p99_us", "max_us"}) table.columns.push_back(std::string(kind) + "_" + what);
  }
  for (const char* error : {"direction_deg", "magnitude_error", "torque_error", "depth_error_m"}) {
    for (const char* what : {"_p50", "_p95", "_max"}) table.columns.push_back(std::string(error) + what);
  }
  table.columns.insert(table.columns.end(), {"missed", "points_tested"});
  for (const Measurement& m : rows) {
    std::vector<std::string> row = {m.workload, m.method, m.setting};
    for (const Times* t : {&m.consecutive, &m.independent}) {
      for (const double us : {t->p50_us, t->p99_us, t->max_us}) row.push_back(Cell(us));
    }
    for (const Errors* e : {&m.direction_deg, &m.magnitude, &m.torque, &m.depth_m}) {
      for (const double error : {e->p50, e->p95, e->max}) row.push_back(Cell(error));
    }
    row.push_back(Cell(m.missed));
    row.push_back(Cell(m.points_tested));
    table.Add(std::move(row));
  }
  return table;
}

Chart ContestChart(const Workload& workload, const std::vector<Measurement>& rows) {
  Chart chart{workload.name + ": " + workload.description,
              "mark: median time of consecutive poses; line to the right: to the 99th percentile, tick: worst",
              {}};
  const auto panel = [&](const char* title, const char* unit, Errors Measurement::*errors, double scale) {
    Panel p;
    p.title = title;
    p.x_title = "time per query [us]";
    p.y_title = unit;
    for (const Measurement& m : rows) {
      if (!std::isfinite((m.*errors).p50)) continue;
      auto series = std::find_if(p.series.begin(), p.series.end(), [&](const Series& s) { return s.name == m.method; });
      if (series == p.series.end()) series = p.series.insert(p.series.end(), Series{m.method, {}, false});
      series->points.push_back({m.consecutive.p50_us, std::max(scale * (m.*errors).p50, kLeastError), m.mark,
                                m.consecutive.p99_us, m.consecutive.max_us});
    }
    if (!p.series.empty()) chart.panels.push_back(std::move(p));
  };
  panel("Force direction", "error, median [degrees]", &Measurement::direction_deg, 1.0);
  panel("Force magnitude", "error, median [%]", &Measurement::magnitude, 100.0);
  panel("Torque", "error, median [% of force times radius]", &Measurement::torque, 100.0);
  panel("Deepest penetration", "error, median [mm]", &Measurement::depth_m, 1e3);
  return chart;
}

void PrintContest(const Workload& workload, const std::vector<Measurement>& rows) {
  std::printf("\n%s: %s\n  %-10s %-18s %21s %21s %15s %13s %9s %11s %7s\n", workload.name.c_str(),
              workload.description.c_str(), "method", "setting", "consecutive p50/p99", "independent p50/p99",
              "dir deg p50/p95", "magn. % p50/95", "torque %", "depth um", "missed");
  for (const Measurement& m : rows) {
    const auto pair = [](double a, double b, double scale) { return Short(scale * a) + " / " + Short(scale * b); };
    std::printf("  %-10s %-18s %18s us %18s us %15s %13s %9s %11s %7s\n", m.method.c_str(), m.setting.c_str(),
                pair(m.consecutive.p50_us, m.consecutive.p99_us, 1.0).c_str(),
                pair(m.independent.p50_us, m.independent.p99_us, 1.0).c_str(),
                pair(m.direction_deg.p50, m.direction_deg.p95, 1.0).c_str(),
                pair(m.magnitude.p50, m.magnitude.p95, 100.0).c_str(), Short(100.0 * m.torque.p50).c_str(),
                Short(1e6 * m.depth_m.p50).c_str(), Short(m.missed).c_str());
  }
  std::fflush(stdout);
}

}  // namespace contact
