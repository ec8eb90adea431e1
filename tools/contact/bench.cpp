#include "tools/contact/bench.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>

#include "core/clock.hpp"
#include "tools/contact/chart.hpp"

namespace contact {
namespace {

constexpr int kMaxRounds = 25;
constexpr double kSecondsEach = 0.6;  // of one contender on one workload
constexpr std::uint32_t kMiddlePoints = 16384;

double Quantile(std::vector<double> v, double q) {
  if (v.empty()) return -1.0;
  std::sort(v.begin(), v.end());
  return v[static_cast<std::size_t>(q * static_cast<double>(v.size() - 1) + 0.5)];
}

struct Runner {
  const Contender* contender = nullptr;
  std::unique_ptr<Method> method;
  Measurement m;
  std::vector<double> times_us;
  double spent_s = 0.0;
};

double AngleDeg(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180.0 / 3.14159265358979323846;
}

void Compare(const Workload& workload, const std::vector<Answer>& truth, Runner* runner) {
  double radius = 0.0;
  for (const glm::dvec3& v : workload.B.vertices) radius = std::max(radius, glm::length(v));
  std::vector<double> direction, magnitude, torque, depth;
  int missed = 0;
  int touching = 0;
  for (std::size_t i = 0; i < workload.poses.size(); ++i) {
    const Answer& exact = truth[i];
    const double f = glm::length(exact.force_A);
    if (!(f > 0.0)) continue;
    ++touching;
    const Answer answer = runner->method->Query(workload.poses[i]);
    if (answer.contacts == 0) {
      ++missed;
      continue;
    }
    depth.push_back(std::abs(answer.signed_distance_m - exact.signed_distance_m));
    if (!runner->contender->has_wrench || !(glm::length(answer.force_A) > 0.0)) continue;
    direction.push_back(AngleDeg(answer.force_A, exact.force_A));
    if (!runner->contender->has_magnitude) continue;
    magnitude.push_back(std::abs(glm::length(answer.force_A) / f - 1.0));
    torque.push_back(glm::length(answer.moment_A - exact.moment_A) / (f * radius));
  }
  Measurement& m = runner->m;
  m.direction_deg = Quantile(direction, 0.5);
  m.direction_worst_deg = Quantile(direction, 1.0);
  m.magnitude_error = Quantile(magnitude, 0.5);
  m.magnitude_worst = Quantile(magnitude, 1.0);
  m.torque_error = Quantile(torque, 0.5);
  m.torque_worst = Quantile(torque, 1.0);
  m.depth_error_m = Quantile(depth, 0.5);
  m.depth_worst_m = Quantile(depth, 1.0);
  m.missed = touching > 0 ? static_cast<double>(missed) / touching : 0.0;
}

std::string Number(double value) {
  if (value < 0.0) return "";
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return text;
}

std::string ShortNumber(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.3g", value);
  return value < 0.0 ? "-" : text;
}

constexpr const char* kColumns =
    "workload,method,setting,time_p50_us,time_p99_us,time_max_us,times_paper,build_s,direction_deg,direction_worst_deg,"
    "magnitude_error,magnitude_worst,torque_error,torque_worst,depth_error_m,depth_worst_m,missed";

std::vector<double> Numbers(const Measurement& m) {
  return {m.time_p50_us,   m.time_p99_us,         m.time_max_us,     m.times_paper,     m.build_s,
          m.direction_deg, m.direction_worst_deg, m.magnitude_error, m.magnitude_worst, m.torque_error,
          m.torque_worst,  m.depth_error_m,       m.depth_worst_m,   m.missed};
}

std::string Csv(const std::vector<Measurement>& rows) {
  std::string text = std::string(kColumns) + "\n";
  for (const Measurement& m : rows) {
    text += m.workload + "," + m.method + "," + m.setting;
    for (const double value : Numbers(m)) text += "," + Number(value);
    text += "\n";
  }
  return text;
}

std::string Json(const std::vector<Measurement>& rows, const std::vector<std::string>& skipped) {
  const auto quote = [](const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
      if (c == '"' || c == '\\') out += '\\';
      out += c;
    }
    return out + "\"";
  };
  std::vector<std::string> names;
  std::string columns = kColumns;
  for (std::size_t at = 0; at != std::string::npos;) {
    const std::size_t comma = columns.find(',', at);
    names.push_back(columns.substr(at, comma == std::string::npos ? comma : comma - at));
    at = comma == std::string::npos ? comma : comma + 1;
  }
  std::string text = "{\n  \"bench\": \"vps\",\n  \"skipped\": [";
  for (std::size_t i = 0; i < skipped.size(); ++i) text += (i ? ", " : "") + quote(skipped[i]);
  text += "],\n  \"rows\": [\n";
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Measurement& m = rows[r];
    text += "    {\"workload\": " + quote(m.workload) + ", \"method\": " + quote(m.method) +
            ", \"setting\": " + quote(m.setting);
    const std::vector<double> numbers = Numbers(m);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      text += ", " + quote(names[i + 3]) + ": " + (numbers[i] < 0.0 ? "null" : Number(numbers[i]));
    }
    text += r + 1 < rows.size() ? "},\n" : "}\n";
  }
  return text + "  ]\n}\n";
}

core::Result<void> Write(const std::filesystem::path& file, const std::string& text) {
  const std::filesystem::path partial = file.string() + ".partial";
  std::error_code error;
  {
    std::ofstream stream(partial, std::ios::binary | std::ios::trunc);
    stream << text;
    stream.close();
    if (stream) std::filesystem::rename(partial, file, error);
    if (stream && !error) return {};
  }
  std::filesystem::remove(partial, error);
  return core::Fail(core::ErrorCode::kIo, file.string() + ": cannot be written");
}

core::Result<std::vector<Measurement>> RunWorkload(const Workload& workload, const std::vector<Contender>& contenders) {
  std::printf("\n%s: %s (%zu and %zu triangles, %zu poses)\n", workload.name.c_str(), workload.description.c_str(),
              workload.A.triangles.size(), workload.B.triangles.size(), workload.poses.size());
  std::fflush(stdout);
  const auto oracle = MakeOracleMethod(workload.A, workload.B, workload.oracle_accuracy);
  if (!oracle) return tl::unexpected(oracle.error());
  std::vector<Answer> truth;
  std::vector<double> oracle_us;
  for (const core::Pose& X_AB : workload.poses) {
    const std::int64_t start_ns = core::MonotonicNow_ns();
    truth.push_back((*oracle)->Query(X_AB));
    oracle_us.push_back(1e-3 * static_cast<double>(core::MonotonicNow_ns() - start_ns));
  }
  std::vector<Runner> runners;
  for (const Contender& contender : contenders) {
    Runner runner;
    runner.contender = &contender;
    runner.m.workload = workload.name;
    runner.m.method = contender.method;
    runner.m.setting = contender.setting;
    const std::int64_t start_ns = core::MonotonicNow_ns();
    auto method = contender.make(workload);
    runner.m.build_s = 1e-9 * static_cast<double>(core::MonotonicNow_ns() - start_ns);
    if (!method) {
      std::printf("  %-10s %-22s left out: %s\n", contender.method.c_str(), contender.setting.c_str(),
                  method.error().detail.c_str());
      continue;
    }
    runner.method = std::move(*method);
    Compare(workload, truth, &runner);  // also warms it up
    runners.push_back(std::move(runner));
  }
  for (int round = 0; round < kMaxRounds; ++round) {
    for (Runner& runner : runners) {
      if (runner.spent_s > kSecondsEach && round > 0) continue;
      // A cycle of a running simulation finds its data warm: one pass that does not count, unless it is long.
      if (round > 0 && runner.spent_s < 0.02 * round) {
        for (const core::Pose& X_AB : workload.poses) runner.method->Query(X_AB);
      }
      for (const core::Pose& X_AB : workload.poses) {
        const std::int64_t start_ns = core::MonotonicNow_ns();
        runner.method->Query(X_AB);
        const double us = 1e-3 * static_cast<double>(core::MonotonicNow_ns() - start_ns);
        runner.times_us.push_back(us);
        runner.spent_s += 1e-6 * us;
      }
    }
  }
  double reference_us = 0.0;
  for (Runner& runner : runners) {
    runner.m.time_p50_us = Quantile(runner.times_us, 0.5);
    runner.m.time_p99_us = Quantile(runner.times_us, 0.99);
    runner.m.time_max_us = Quantile(runner.times_us, 1.0);
    if (reference_us == 0.0 && runner.m.method == "paper") reference_us = runner.m.time_p50_us;
  }
  std::vector<Measurement> rows;
  std::printf("  %-10s %-22s %10s %8s %9s %9s %9s %10s %7s\n", "method", "setting", "p50 us", "x paper", "dir deg",
              "magn. %", "torque %", "depth mm", "missed");
  for (Runner& runner : runners) {
    Measurement& m = runner.m;
    m.times_paper = reference_us > 0.0 ? m.time_p50_us / reference_us : -1.0;
    const auto cell = [](double value, double scale) { return ShortNumber(scale * value); };
    std::printf("  %-10s %-22s %10s %8.3g %9s %9s %9s %10s %5.0f %%\n", m.method.c_str(), m.setting.c_str(),
                ShortNumber(m.time_p50_us).c_str(), m.times_paper, cell(m.direction_deg, 1).c_str(),
                cell(m.magnitude_error, 100).c_str(), cell(m.torque_error, 100).c_str(),
                cell(m.depth_error_m, 1e3).c_str(), 100.0 * m.missed);
    rows.push_back(m);
  }
  std::printf("  (exact answer: %.3g ms a pose)\n", 1e-3 * Quantile(oracle_us, 0.5));
  return rows;
}

Chart MakeChart(const Workload& workload, const std::vector<Measurement>& rows) {
  Chart chart;
  chart.title = workload.name + ": " + workload.description;
  const auto panel = [&](const char* title, double Measurement::*error, double scale) {
    Panel p{title, "time per query, us", {}};
    for (const Measurement& m : rows) {
      if (m.*error < 0.0) continue;
      auto series = std::find_if(p.series.begin(), p.series.end(), [&](const Series& s) { return s.name == m.method; });
      if (series == p.series.end()) {
        p.series.push_back({m.method, {}});
        series = p.series.end() - 1;
      }
      series->points.push_back({m.time_p50_us, scale * m.*error, m.setting});
    }
    chart.panels.push_back(std::move(p));
  };
  panel("force direction, degrees off", &Measurement::direction_deg, 1.0);
  panel("force magnitude, % off", &Measurement::magnitude_error, 100.0);
  panel("torque, % of force times radius off", &Measurement::torque_error, 100.0);
  panel("depth, mm off", &Measurement::depth_error_m, 1e3);
  return chart;
}

}  // namespace

std::vector<Contender> OwnContenders() {
  std::vector<Contender> all;
  const auto add = [&](double factor, std::uint32_t num_points) {
    char setting[64];
    std::snprintf(setting, sizeof(setting), "%g s; %u points", factor, num_points);
    all.push_back({"paper", setting, [=](const Workload& w) {
                     return MakePaperMethod(w.A, w.B, {0.0, factor * w.voxel_size_m, num_points}, true);
                   }});
  };
  const auto add_fast = [&](double factor, std::uint32_t num_points) {
    char setting[64];
    std::snprintf(setting, sizeof(setting), "%g s; %u points", factor, num_points);
    all.push_back({"fast", setting, [=](const Workload& w) {
                     return MakeFastMethod(w.A, w.B, {0.0, factor * w.voxel_size_m, num_points});
                   }});
  };
  add(1.0, kMiddlePoints);  // first: what times are compared with
  add(2.0, kMiddlePoints);
  add(0.5, kMiddlePoints);
  add(1.0, kMiddlePoints / 4);
  add(1.0, kMiddlePoints * 4);
  add_fast(1.0, kMiddlePoints);
  add_fast(2.0, kMiddlePoints);
  add_fast(0.5, kMiddlePoints);
  add_fast(1.0, kMiddlePoints / 4);
  add_fast(1.0, kMiddlePoints * 4);
  return all;
}

core::Result<void> RunBench(const BenchOptions& options, const std::vector<Contender>& contenders) {
  std::error_code error;
  if (!options.plot.empty() && !std::filesystem::create_directories(options.plot, error) && error) {
    return core::Fail(core::ErrorCode::kIo, options.plot.string() + ": cannot be made: " + error.message());
  }
  const Workloads workloads = MakeWorkloads(options.scenarios, options.meshes);
  for (const std::string& skipped : workloads.skipped) std::printf("skipped %s\n", skipped.c_str());
  std::vector<Measurement> all;
  std::string known;
  for (const Workload& workload : workloads.found) {
    known += " " + workload.name;
    if (!options.only.empty() && workload.name != options.only) continue;
    const auto rows = RunWorkload(workload, contenders);
    if (!rows) return tl::unexpected(rows.error());
    all.insert(all.end(), rows->begin(), rows->end());
    if (options.plot.empty()) continue;
    if (auto done = Write(options.plot / (workload.name + ".csv"), Csv(*rows)); !done) return done;
    if (auto done = Write(options.plot / (workload.name + ".svg"), DrawSvg(MakeChart(workload, *rows))); !done) {
      return done;
    }
  }
  if (all.empty()) return core::Fail(core::ErrorCode::kInvalidInput, "no pair '" + options.only + "'; known:" + known);
  if (options.json.empty()) return {};
  return Write(options.json, Json(all, workloads.skipped));
}

int BenchMain(const BenchOptions& options, const std::vector<Contender>& contenders) {
  const auto done = RunBench(options, contenders);
  if (done) return 0;
  std::fprintf(stderr, "oos bench: %s\n", done.error().detail.c_str());
  return 2;
}

}  // namespace contact
