#include "nodes/visual_node/window/space_mouse.hpp"

#include <poll.h>
#include <spnav.h>

#include <algorithm>
#include <utility>

namespace visual_node {
namespace {

constexpr double kTry_s = 1.0;   // between two looks for the daemon
constexpr double kFull = 350.0;  // of an axis that is pushed as far as it goes, by the daemon's default sensitivity

double Share(int value) {
  return std::clamp(value / kFull, -1.0, 1.0);
}

// libspnav does not report that its daemon has closed the connection.
bool HasEnded() {
  pollfd end{spnav_fd(), POLLRDHUP, 0};
  return poll(&end, 1, 0) != 0;
}

}  // namespace

SpaceMouse::~SpaceMouse() {
  Close();
}

void SpaceMouse::Close() {
  if (!is_open_) return;
  spnav_close();
  is_open_ = false;
  push_ = turn_ = glm::dvec3(0.0);
}

void SpaceMouse::Take(double now_s) {
  if (!is_open_) {
    if (now_s < next_try_s_) return;
    next_try_s_ = now_s + kTry_s;
    is_open_ = spnav_open() != -1;
    if (!is_open_) return;
  }
  // The daemon's axes: x to the right, y up, z away from the person.
  spnav_event event;
  while (spnav_poll_event(&event) != 0) {
    if (event.type == SPNAV_EVENT_MOTION) {
      push_ = {Share(event.motion.x), Share(event.motion.y), Share(event.motion.z)};
      turn_ = {Share(event.motion.rx), Share(event.motion.ry), Share(event.motion.rz)};
    } else if (event.type == SPNAV_EVENT_BUTTON && event.button.press != 0) {
      ++(event.button.bnum == 0 ? left_presses_ : right_presses_);
    }
  }
  if (HasEnded()) Close();
}

void SpaceMouse::Read(double now_s, view::SteeringWish* wish) {
  Take(now_s);
  wish->push += push_;
  wish->turn += turn_;
  wish->is_held = wish->is_held || push_ != glm::dvec3(0.0) || turn_ != glm::dvec3(0.0);
}

void SpaceMouse::Drop(double now_s) {
  Take(now_s);
  left_presses_ = right_presses_ = 0;
}

int SpaceMouse::TakeLeftPresses() {
  return std::exchange(left_presses_, 0);
}

int SpaceMouse::TakeRightPresses() {
  return std::exchange(right_presses_, 0);
}

}  // namespace visual_node
