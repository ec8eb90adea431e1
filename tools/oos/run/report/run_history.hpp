#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace oos {

// A quantity over a run's time.
struct Course {
  struct Point {
    double t_s = 0.0;
    double value = 0.0;
  };
  std::string name;
  std::vector<Point> points;
};

// What happened when in a run, from the files that its nodes left. What a file does not hold is empty.
struct RunHistory {
  struct Step {
    std::string name;
    double begin_s = 0.0;
  };
  std::vector<Step> steps;         // as they were entered
  std::vector<Course> force_N;     // on each hand
  std::vector<Course> latency_ms;  // t1, t2_image: the worst of each interval
  Course late_cycles;              // of haptic_node, since its start
  double film_from_s = 0.0;        // the first step, from the first message of the recorded scene
  double film_length_s = 0.0;      // from there to the end

  // Times are simulated ones where the recorded scene gives them; without it they count from the first sample.
  static RunHistory Read(const std::filesystem::path& folder);
};

// The recording that the run's viewer left.
std::filesystem::path SceneRecording(const std::filesystem::path& folder);

// The highest value of each of `num` equal intervals of time.
std::vector<Course::Point> Worst(const std::vector<Course::Point>& points, std::size_t num);

}  // namespace oos
