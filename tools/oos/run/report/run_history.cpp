#include "tools/oos/run/report/run_history.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <map>
#include <optional>

#include "bus/log/mcap_indexed_reader.hpp"
#include "bus/wire/codec.hpp"
#include "core/messages/logic.hpp"
#include "tools/oos/run/latency/latency_table.hpp"
#include "view/recorded_feed.hpp"

namespace oos {
namespace {

constexpr std::size_t kPointsOfACourse = 400;  // more than a chart has pixels for

// Before the origin of time is known.
struct Sample {
  std::int64_t time_ns = 0;
  double value = 0.0;
};
using Samples = std::map<std::string, std::vector<Sample>>;

Samples ReadForces(const std::filesystem::path& file) {
  Samples forces;
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);  // the header: time_ns,role,force_N,torque_Nm
  while (std::getline(in, line)) {
    char* rest = nullptr;
    const std::int64_t time_ns = std::strtoll(line.c_str(), &rest, 10);
    if (*rest != ',') continue;
    const long role = std::strtol(rest + 1, &rest, 10);
    if (*rest != ',') continue;
    forces["hand " + std::to_string(role + 1)].push_back({time_ns, std::strtod(rest + 1, nullptr)});
  }
  return forces;
}

Samples ReadLatencies(const std::filesystem::path& file) {
  Samples latencies;
  const auto rows = ReadLatencyRows(file);
  if (!rows) return latencies;
  for (const LatencyRow& row : *rows) {
    if ((row.chain != "t1" && row.chain != "t2_image") || row.trace.stamps.empty()) continue;
    latencies[row.chain].push_back({row.trace.origin_ns, 1e-6 * row.trace.stamps.back().offset_ns});
  }
  return latencies;
}

// Steps and late cycles from the recorded scene.
struct Recorded {
  std::vector<std::pair<std::int64_t, std::string>> steps;  // with simulated times
  std::optional<std::int64_t> origin_ns;                    // CLOCK_MONOTONIC at simulated time 0
  std::vector<Sample> late;
  std::int64_t first_ns = 0, last_ns = 0;
};

Recorded ReadScene(const std::filesystem::path& file) {
  Recorded recorded;
  auto reader = bus::log::McapIndexedReader::Open(file);
  if (!reader) return recorded;
  const std::string haptic = bus::FiguresTopic("haptic_node");
  const auto see = [&](const bus::log::Channel& channel, const bus::log::Message& message) {
    const auto time_ns = static_cast<std::int64_t>(message.log_time_ns);
    if (view::RecordedFeed::IsRead(channel)) {
      if (recorded.first_ns == 0) recorded.first_ns = time_ns;
      recorded.last_ns = time_ns;
    }
    const std::string bytes(message.data.begin(), message.data.end());
    if (core::LogicStatus status; channel.topic == bus::kLogicStatusTopic && bus::DecodeState(bytes, &status)) {
      const bool is_new = recorded.steps.empty() || recorded.steps.back().second != status.step;
      if (is_new && !status.step.empty()) recorded.steps.emplace_back(status.time_ns, status.step);
      // A viewer that joins late gets the status late: the one that was the fastest to arrive counts.
      if (status.time_ns > 0) {
        recorded.origin_ns = std::min(recorded.origin_ns.value_or(time_ns), time_ns - status.time_ns);
      }
    }
    if (core::Figures figures; channel.topic == haptic && bus::DecodeState(bytes, &figures)) {
      if (const double* misses = bus::FindFigure(figures, "misses")) recorded.late.push_back({time_ns, *misses});
    }
    return true;
  };
  if (!reader->ReadMessages(see)) return {};
  return recorded;
}

std::vector<Course::Point> Points(const std::vector<Sample>& samples, std::int64_t origin_ns) {
  std::vector<Course::Point> points;
  for (const Sample& sample : samples) {
    points.push_back({1e-9 * static_cast<double>(sample.time_ns - origin_ns), sample.value});
  }
  return points;
}

std::vector<Course> Courses(const Samples& samples, std::int64_t origin_ns) {
  std::vector<Course> courses;
  for (const auto& [name, its] : samples) courses.push_back({name, Worst(Points(its, origin_ns), kPointsOfACourse)});
  return courses;
}

}  // namespace

std::filesystem::path SceneRecording(const std::filesystem::path& folder) {
  return folder / "scene.mcap";
}

std::vector<Course::Point> Worst(const std::vector<Course::Point>& points, std::size_t num) {
  if (points.size() <= num) return points;
  const auto [first, last] =
      std::minmax_element(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.t_s < b.t_s; });
  const double begin_s = first->t_s;
  const double width_s = std::max(last->t_s - begin_s, 1e-9) / static_cast<double>(num);
  std::vector<Course::Point> worst(num, {0.0, -std::numeric_limits<double>::infinity()});
  for (const Course::Point& point : points) {
    const auto interval = std::min(num - 1, static_cast<std::size_t>((point.t_s - begin_s) / width_s));
    if (point.value > worst[interval].value) worst[interval] = point;
  }
  std::erase_if(worst,
                [](const Course::Point& point) { return point.value == -std::numeric_limits<double>::infinity(); });
  return worst;
}

RunHistory RunHistory::Read(const std::filesystem::path& folder) {
  const Samples forces = ReadForces(folder / "device_bridge_force.csv");
  const Samples latencies = ReadLatencies(folder / "latency.csv");
  const Recorded recorded = ReadScene(SceneRecording(folder));
  std::int64_t origin_ns = recorded.origin_ns.value_or(recorded.first_ns);
  if (origin_ns == 0) {
    for (const auto& [name, samples] : forces) origin_ns = samples.front().time_ns;
  }
  RunHistory history;
  for (const auto& [time_ns, step] : recorded.steps) {
    history.steps.push_back({step, 1e-9 * static_cast<double>(time_ns)});
  }
  history.force_N = Courses(forces, origin_ns);
  history.latency_ms = Courses(latencies, origin_ns);
  history.late_cycles = {"late cycles", Points(recorded.late, origin_ns)};
  const double begin_s = 1e-9 * static_cast<double>(recorded.first_ns - origin_ns);
  const double first_step_s = history.steps.empty() ? begin_s : history.steps.front().begin_s;
  history.film_from_s = std::max(0.0, first_step_s - begin_s);
  history.film_length_s = 1e-9 * static_cast<double>(recorded.last_ns - recorded.first_ns) - history.film_from_s;
  return history;
}

}  // namespace oos
