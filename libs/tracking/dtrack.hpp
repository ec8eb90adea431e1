#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/pose.hpp"

namespace tracking {

// What one datagram of ART's DTrack says [ART, DTrack user manual, appendix B; DTrackSDK]: a frame of its cameras, as
// lines of ASCII. T is the tracker's room frame. Lengths are metres and angles radians here; DTrack writes mm and deg.

struct TrackedBody {
  int id = 0;
  double quality = -1.0;  // 0 to 1; negative: not tracked, and then there is no pose
  core::Pose X_TB;
  [[nodiscard]] bool is_tracked() const { return quality >= 0.0; }
};

struct TrackedFlystick {
  TrackedBody body;
  std::uint32_t buttons = 0;  // bit 0: the first; valid also while it is not tracked
  int num_buttons = 0;
  std::array<double, 8> controllers{};  // -1 to 1; of Flystick2 the stick, horizontal and vertical (up is positive)
  int num_controllers = 0;
};

// In the frame of the back of the hand. From the tip: phalanges, and the angles between them.
struct TrackedFinger {
  core::Pose X_BF;  // of the tip
  double radius_m = 0.0;
  double outer_m = 0.0, outer_middle_rad = 0.0, middle_m = 0.0, middle_inner_rad = 0.0, inner_m = 0.0;
};
struct TrackedHand {
  TrackedBody body;  // the back of the hand
  bool is_right = false;
  std::vector<TrackedFinger> fingers;  // thumb first
};

struct DtrackFrame {
  std::optional<std::uint32_t> number;  // fr
  std::optional<double> time_s;         // ts: of day, of the tracker's clock
  std::optional<int> num_calibrated;    // 6dcal; tracked ones are fewer
  std::vector<TrackedBody> bodies;      // 6d: those that are tracked; 6di: all, as DTrack is set to send
  std::vector<TrackedFlystick> flysticks;
  std::vector<TrackedHand> hands;
};

// Lines of other kinds are passed over: a controller may send what this does not know. A line that is cut off or wrong
// gives what was before the mistake, and a complaint: which line, what is wrong. Any bytes are allowed.
DtrackFrame ParseDtrack(std::string_view datagram, std::vector<std::string>* complaints);

}  // namespace tracking
