#include "view/scene_history.hpp"

#include <algorithm>
#include <cstdio>

namespace view {
namespace {

constexpr glm::vec3 kPathColors[] = {
    {0.25f, 0.80f, 0.95f}, {1.0f, 0.55f, 0.10f}, {0.65f, 1.0f, 0.25f}, {1.0f, 0.35f, 0.75f}, {0.95f, 0.9f, 0.4f}};
constexpr glm::vec3 kText{0.75f, 0.80f, 0.86f};
constexpr std::size_t kMaxSteps = 24;

double Seconds(std::int64_t ns) {
  return 1e-9 * static_cast<double>(ns);
}

}  // namespace

void SceneHistory::Take(const Scene& scene, std::int64_t now_ns) {
  if (!ticks_.empty() && scene.time_ns < ticks_.back().time_ns) {
    steps_.clear();
    ticks_.clear();
    std::fill(paths_.begin(), paths_.end(), Path{});
  }
  TakeStep(scene);
  if (scene.time_ns == 0) return;
  TakeClock(scene, now_ns);
  if (now_ns < next_path_ns_) return;
  next_path_ns_ = now_ns + kPathPeriod_ns;
  TakePaths(scene);
}

void SceneHistory::TakeClock(const Scene& scene, std::int64_t now_ns) {
  if (!ticks_.empty() && now_ns - ticks_.back().now_ns < kClockPeriod_ns) return;
  if (ticks_.empty()) first_ = {now_ns, scene.time_ns};
  ticks_.push_back({now_ns, scene.time_ns});
  if (ticks_.size() > kClockSamples) ticks_.pop_front();
}

void SceneHistory::TakePaths(const Scene& scene) {
  for (std::size_t i = 0; i < paths_.size() && i < scene.instances.size(); ++i) {
    if (!on_path_[i]) continue;
    Path& path = paths_[i];
    const glm::vec3 p_W(scene.instances[i].X_WM.translation);
    if (!path.p_W.empty() && glm::distance(path.p_W.back(), p_W) < static_cast<float>(kPathStep_m)) continue;
    path.p_W.push_back(p_W);
    if (path.p_W.size() > kMaxPathPoints) path.p_W.pop_front();
    path.shared.reset();
  }
}

void SceneHistory::TakeStep(const Scene& scene) {
  const bool goes_on = !steps_.empty() && steps_.back().end_ns < 0;
  const bool is_new = !scene.step.empty() && (!goes_on || steps_.back().name != scene.step);
  const bool is_over = scene.is_final || scene.is_failed;
  if (goes_on && (is_over || (is_new && steps_.back().name != scene.step))) steps_.back().end_ns = scene.time_ns;
  if (!is_new || is_over || steps_.size() >= kMaxSteps) return;
  steps_.push_back({scene.step, scene.time_ns});
}

void SceneHistory::TakeFigure(Course course, double value) {
  std::deque<float>& values = courses_[static_cast<std::size_t>(course)].values;
  values.push_back(static_cast<float>(value));
  if (values.size() > kCourseLength) values.pop_front();
}

void SceneHistory::TakeCount(Course course, double count) {
  double& last = courses_[static_cast<std::size_t>(course)].count;
  if (last >= 0.0) TakeFigure(course, std::max(0.0, count - last));
  last = count;
}

void SceneHistory::AddPaths(Scene* scene) {
  std::size_t number = 0;
  for (Path& path : paths_) {
    if (path.p_W.size() < 2) continue;
    if (path.shared == nullptr) {
      path.shared = std::make_shared<const std::vector<glm::vec3>>(path.p_W.begin(), path.p_W.end());
    }
    scene->lines.push_back({path.shared, kPathColors[number++ % std::size(kPathColors)], 1.5f});
  }
}

void SceneHistory::AddGraphs(Scene* scene) const {
  struct Look {
    Course course;
    const char* title;
    float least_full;  // least value of a full bar
    glm::vec3 color;
  };
  for (const Look& look : {Look{Course::kT1, "t1 %.2f ms", 1.0f, {0.25f, 0.80f, 0.95f}},
                           Look{Course::kT2, "to image %.0f ms", 50.0f, {0.65f, 1.0f, 0.25f}},
                           Look{Course::kLateCycles, "late cycles %.0f", 4.0f, {1.0f, 0.45f, 0.2f}}}) {
    const std::deque<float>& values = courses_[static_cast<std::size_t>(look.course)].values;
    if (values.empty()) continue;
    Graph graph;
    graph.values.assign(kCourseLength - values.size(), 0.0f);
    graph.values.insert(graph.values.end(), values.begin(), values.end());
    const float most = *std::max_element(values.begin(), values.end());
    graph.most = std::max(look.least_full, most);
    graph.color = look.color;
    char title[64];
    std::snprintf(title, sizeof title, look.title, static_cast<double>(values.back()));
    graph.title = title;
    std::snprintf(title, sizeof title, " (most %.3g)", static_cast<double>(most));
    graph.title += title;
    scene->graphs.push_back(std::move(graph));
  }
}

void SceneHistory::AddSteps(Scene* scene) const {
  for (const Step& step : steps_) {
    const bool goes_on = step.end_ns < 0;
    char line[96];
    std::snprintf(line, sizeof line, "%s   %.1f s%s", step.name.c_str(),
                  Seconds((goes_on ? scene->time_ns : step.end_ns) - step.begin_ns), goes_on ? " ..." : "");
    scene->texts.push_back({Anchor::kTopRight, TextStyle::kSmall, goes_on ? glm::vec3(1.0f) : kText, line});
  }
}

void SceneHistory::AddClock(Scene* scene) const {
  if (ticks_.size() < 2) return;
  const Tick& from = ticks_.front();
  const Tick& to = ticks_.back();
  const double rate = Seconds(to.time_ns - from.time_ns) / std::max(1e-9, Seconds(to.now_ns - from.now_ns));
  char line[96];
  std::snprintf(line, sizeof line, "simulated %.1f s in %.1f s, now at %.2f of real time",
                Seconds(to.time_ns - first_.time_ns), Seconds(to.now_ns - first_.now_ns), rate);
  scene->texts.push_back({Anchor::kTopRight, TextStyle::kSmall, kText, line});
}

}  // namespace view
