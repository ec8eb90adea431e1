#include "nodes/visual_node/summary.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

namespace visual_node {
namespace {

nlohmann::json Milliseconds(const bus::LatencyStats& stats) {
  return {{"mean", 1e-6 * stats.mean_ns()},
          {"p50", 1e-6 * stats.p50_ns()},
          {"p90", 1e-6 * stats.p90_ns()},
          {"p99", 1e-6 * stats.p99_ns()},
          {"p99.9", 1e-6 * stats.p999_ns()},
          {"max", 1e-6 * static_cast<double>(stats.max_ns())},
          {"n", stats.count()}};
}

}  // namespace

core::Result<void> Summary::Write(const std::filesystem::path& file) const {
  nlohmann::json json = {{"node", "visual_node"},
                         {"scenario", scenario},
                         {"gl_renderer", gl_renderer},
                         {"triangles", num_triangles},
                         {"frames", frames},
                         {"seconds", seconds},
                         {"fps", seconds > 0.0 ? static_cast<double>(frames) / seconds : 0.0},
                         {"render_scale", frames > 0 ? render_scale_sum / static_cast<double>(frames) : 0.0},
                         {"cpu_ms_per_frame", frames > 0 ? 1e3 * cpu_s / static_cast<double>(frames) : 0.0},
                         {"states", states},
                         {"draw_ms", Milliseconds(draw)},
                         {"t2_state_ms", Milliseconds(t2_state)},
                         {"t2_state_direct_ms", Milliseconds(t2_state_direct)},
                         {"t2_image_ms", Milliseconds(t2_image)},
                         {"dropped", counters.dropped},
                         {"bus",
                          {{"sent", counters.sent},
                           {"received", counters.received},
                           {"dropped", counters.dropped},
                           {"refused", counters.refused}}}};
  json["clock_bounds_ns"] = clock_bounds_ns;
  nlohmann::json lost = nlohmann::json::object();
  for (const bus::TopicCounters& topic : counters.topics) {
    if (topic.dropped > 0) lost[topic.topic] = topic.dropped;
  }
  json["bus"]["dropped_by_topic"] = lost;
  std::ofstream out(file);
  out << json.dump(2) << "\n";
  if (!out.flush())
    return core::Fail(core::ErrorCode::kIo, "cannot write " + file.string() + "; is the folder writable?");
  return {};
}

}  // namespace visual_node
