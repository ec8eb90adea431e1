#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace system_tests {

// What a wall has shown in step with the others: its walls.csv (nodes/visual_node/walls), by frame.
struct WallFrame {
  std::uint64_t tick = 0;  // of the physics state in it
  std::int64_t shown_ns = 0;
};
using WallFrames = std::map<std::uint64_t, WallFrame>;

inline WallFrames ReadWallFrames(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  WallFrames frames;
  while (std::getline(in, line)) {
    std::uint64_t number = 0;
    WallFrame frame;
    int is_in_step = 0;
    char comma = 0;
    std::istringstream(line) >> number >> comma >> frame.tick >> comma >> frame.shown_ns >> comma >> is_in_step;
    if (is_in_step == 1) frames[number] = frame;
  }
  return frames;
}

// How well walls were in step, over the frames that all have shown. Their times are of one clock.
struct WallComparison {
  std::size_t num_common = 0;
  std::size_t num_other_states = 0;  // a wall showed another tick than the first one
  std::size_t num_overtaken = 0;     // a wall showed the next frame before all had shown this one
  std::vector<double> apart_ms;      // between the first wall to show a frame and the last, sorted

  explicit WallComparison(const std::vector<WallFrames>& walls) {
    for (const auto& [number, first_wall] : walls.front()) {
      std::int64_t first_ns = first_wall.shown_ns, last_ns = first_ns;
      bool is_common = true, is_other_state = false;
      for (const WallFrames& wall : walls) {
        const auto frame = wall.find(number);
        is_common = is_common && frame != wall.end();
        if (!is_common) break;
        first_ns = std::min(first_ns, frame->second.shown_ns);
        last_ns = std::max(last_ns, frame->second.shown_ns);
        is_other_state = is_other_state || frame->second.tick != first_wall.tick;
      }
      if (!is_common) continue;
      ++num_common;
      num_other_states += is_other_state ? 1 : 0;
      apart_ms.push_back(1e-6 * static_cast<double>(last_ns - first_ns));
      num_overtaken += std::any_of(walls.begin(), walls.end(), [&, after = number + 1](const WallFrames& wall) {
        const auto next = wall.find(after);
        return next != wall.end() && next->second.shown_ns < last_ns;
      });
    }
    std::sort(apart_ms.begin(), apart_ms.end());
  }

  [[nodiscard]] double apart_ms_at(double share) const {
    return apart_ms[static_cast<std::size_t>(share * static_cast<double>(apart_ms.size() - 1))];
  }
};

}  // namespace system_tests
