#pragma once

#include <array>
#include <cstddef>

namespace visual_node {

// Chooses at which share of the window's width and height the scene is drawn, so that a picture takes no longer than it
// may. It decides once every kWindow pictures by their median, so single slow pictures change nothing. What a picture
// takes is assumed to be proportional to its pixels: that is exact enough, since the next decision corrects it.
class RenderScale {
 public:
  static constexpr double kLeast = 0.3;
  static constexpr double kStep = 0.05;
  static constexpr std::size_t kWindow = 9;
  // It goes up only if the next step is expected to take this share of the time, so it does not swing.
  static constexpr double kReserve = 0.85;

  explicit RenderScale(double budget_s) : budget_s_(budget_s) {}
  // Begins with the smallest pictures: the first one is there soon.
  static RenderScale FromLeast(double budget_s) {
    RenderScale scale(budget_s);
    scale.step_ = kLeastSteps;
    return scale;
  }

  // How long the newest picture took.
  void Update(double picture_s);

  [[nodiscard]] double value() const { return step_ * kStep; }

 private:
  static constexpr int kMostSteps = 20;  // of 1 / kStep
  static constexpr int kLeastSteps = static_cast<int>(kLeast / kStep + 0.5);

  double budget_s_;
  int step_ = kMostSteps;
  std::array<double, kWindow> pictures_s_{};
  std::size_t num_pictures_ = 0;
};

}  // namespace visual_node
