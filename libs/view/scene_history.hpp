#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "view/scene.hpp"

namespace view {

// What a scene has been through, for overlays: where parts have been, when steps began, how figures went. Bounded: the
// oldest is forgotten. Not thread-safe.
class SceneHistory {
 public:
  static constexpr std::size_t kMaxPathPoints = 1200;  // of one object: at least 2.4 m
  static constexpr double kPathStep_m = 0.002;
  static constexpr std::size_t kCourseLength = 120;  // 30 s of figures that come four times a second
  static constexpr std::int64_t kPathPeriod_ns = 30'000'000;
  static constexpr std::int64_t kClockPeriod_ns = 100'000'000;
  static constexpr std::size_t kClockSamples = 21;  // the rate is the mean over two seconds

  // Named courses over time. A course exists from its first value on.
  enum class Course : std::uint8_t { kT1, kT2, kLateCycles };

  // `on_path`: objects whose way is kept.
  explicit SceneHistory(std::vector<bool> on_path) : on_path_(std::move(on_path)), paths_(on_path_.size()) {}

  // The scene at a time of the clock of the bus. A simulated time that runs backwards begins all anew.
  void Take(const Scene& scene, std::int64_t now_ns);
  void TakeFigure(Course course, double value);
  // A count that only grows: its course is what was added.
  void TakeCount(Course course, double count);

  void AddPaths(Scene* scene);
  void AddGraphs(Scene* scene) const;
  void AddSteps(Scene* scene) const;
  void AddClock(Scene* scene) const;

 private:
  struct Path {
    std::deque<glm::vec3> p_W;
    SharedPoints shared;  // of p_W; null: to be made anew
  };
  struct Step {
    std::string name;
    std::int64_t begin_ns = 0, end_ns = -1;  // simulated; -1: goes on
  };
  struct Tick {
    std::int64_t now_ns = 0, time_ns = 0;
  };
  struct Values {
    std::deque<float> values;
    double count = -1.0;
  };
  void TakeStep(const Scene& scene);
  void TakePaths(const Scene& scene);
  void TakeClock(const Scene& scene, std::int64_t now_ns);

  std::vector<bool> on_path_;
  std::vector<Path> paths_;
  std::int64_t next_path_ns_ = 0;
  std::vector<Step> steps_;
  std::deque<Tick> ticks_;
  Tick first_;
  Values courses_[3];
};

}  // namespace view
