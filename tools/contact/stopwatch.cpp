#include "tools/contact/stopwatch.hpp"

#include <algorithm>
#include <utility>

#include "core/clock.hpp"

namespace contact {

void Race(std::span<Racer> racers, int passes, double seconds_each) {
  const OneCore pinned;
  std::vector<std::vector<std::vector<double>>> us(racers.size());  // [racer][pose][pass]
  std::vector<double> spent_s(racers.size(), 0.0);
  for (std::size_t r = 0; r < racers.size(); ++r) us[r].resize(racers[r].by_pose ? racers[r].poses.size() : 1);
  for (int pass = 0; pass < passes; ++pass) {
    for (std::size_t r = 0; r < racers.size(); ++r) {
      Racer& racer = racers[r];
      if (racer.poses.empty() || (pass > 0 && spent_s[r] > seconds_each)) continue;
      const std::int64_t turn_ns = core::MonotonicNow_ns();
      if (pass == 0 || spent_s[r] < 0.3 * seconds_each) {
        const std::size_t warm = std::min<std::size_t>(racer.poses.size(), pass == 0 ? 4 : racer.poses.size());
        for (std::size_t i = 0; i < warm; ++i) racer.method->Query(racer.poses[i]);
      }
      const std::int64_t begin_ns = core::MonotonicNow_ns();
      for (std::size_t i = 0; i < racer.poses.size(); ++i) {
        if (!racer.by_pose) {
          racer.method->Query(racer.poses[i]);
          continue;
        }
        const std::int64_t start_ns = core::MonotonicNow_ns();
        racer.method->Query(racer.poses[i]);
        us[r][i].push_back(1e-3 * static_cast<double>(core::MonotonicNow_ns() - start_ns));
      }
      const std::int64_t end_ns = core::MonotonicNow_ns();
      if (!racer.by_pose) {
        us[r][0].push_back(1e-3 * static_cast<double>(end_ns - begin_ns) / static_cast<double>(racer.poses.size()));
      }
      spent_s[r] += 1e-9 * static_cast<double>(end_ns - turn_ns);
    }
  }
  for (std::size_t r = 0; r < racers.size(); ++r) {
    std::vector<double> by_pose;
    for (const auto& passes_us : us[r]) by_pose.push_back(Quantile(passes_us, 0.5));
    racers[r].times = {Quantile(by_pose, 0.5), Quantile(by_pose, 0.99), Quantile(by_pose, 1.0)};
    racers[r].by_pose_us = std::move(by_pose);
  }
}

}  // namespace contact
