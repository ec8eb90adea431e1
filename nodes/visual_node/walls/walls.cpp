#include "nodes/visual_node/walls/walls.hpp"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>

#include "core/clock.hpp"

namespace visual_node {
namespace {

void SleepUntil(std::int64_t time_ns) {
  const timespec until{time_ns / core::kNanosecondsPerSecond, time_ns % core::kNanosecondsPerSecond};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

}  // namespace

// Frames count on from the host's clock, so that those of a first wall that was started again are newer, too.
Walls::Walls(WallLink* link, std::function<bool()> is_stopped)
    : link_(link), is_stopped_(std::move(is_stopped)), barrier_(link->place().walls.size() - 1) {
  named_.frame = static_cast<std::uint64_t>(core::MonotonicNow_ns() / 1'000'000);
}

std::uint64_t Walls::NextTick(const KeptTicks& own) {
  std::vector<NamedTick::Claim> claims;
  for (const WallLink::HeardState& other : link_->states()) {
    claims.push_back({{other.state.kept_tick, other.state.kept}, other.heard_ns});
  }
  return named_tick_.Next(own, claims, core::MonotonicNow_ns());
}

Walls::Frame Walls::Begin(const Frame& wish) {
  frame_ = wish;
  if (link_->place().is_first()) {
    named_.tick = wish.tick;
    named_.X_WR = wish.X_WR;
    named_.X_RH = wish.X_RH;
    named_.eye_distance_m = wish.eye_distance_m;
    frame_.number = ++named_.frame;
    barrier_.Begin(frame_.number, core::MonotonicNow_ns());
    link_->Say(named_);
    return frame_;
  }
  for (;;) {
    const WallLink::HeardFrame heard = link_->frame();
    const std::int64_t now_ns = core::MonotonicNow_ns();
    const bool is_there = heard.heard_ns != 0 && now_ns - heard.heard_ns < Barrier::kSilence_ns;
    if (heard.heard_ns != 0) {
      frame_.X_WR = heard.frame.X_WR;
      frame_.X_RH = heard.frame.X_RH;
      frame_.eye_distance_m = heard.frame.eye_distance_m;
    }
    if (is_there && heard.frame.frame > own_.frame) {
      frame_.number = heard.frame.frame;
      frame_.tick = heard.frame.tick;
      return frame_;
    }
    if (!is_there || is_stopped_()) {
      frame_.number = own_.frame;
      frame_.tick = 0;
      frame_.is_in_step = false;
      return frame_;
    }
    link_->Wait(now_ns + Barrier::kSilence_ns);
  }
}

void Walls::AwaitShow(std::uint64_t tick) {
  own_.frame = frame_.number;
  own_.tick = tick;
  show_ns_ = 0;
  if (frame_.is_in_step) link_->Say(own_);
  if (link_->place().is_first()) {
    AwaitOthers();
  } else if (frame_.is_in_step) {
    AwaitFirst();
  }
  SleepUntil(std::min(show_ns_, core::MonotonicNow_ns() + kMostSleep_ns));
}

void Walls::AwaitOthers() {
  for (;;) {
    const std::vector<WallLink::HeardState> states = link_->states();
    for (std::size_t i = 1; i < states.size(); ++i) {
      if (states[i].heard_ns != 0) barrier_.Take(i - 1, states[i].state.frame, states[i].heard_ns);
    }
    const std::int64_t now_ns = core::MonotonicNow_ns();
    const bool is_open = barrier_.IsOpen(now_ns);
    if (is_open || is_stopped_()) {
      frame_.is_in_step = is_open;
      num_in_step_ = 1 + barrier_.NumInStep(now_ns);
      show_ns_ = now_ns + (num_in_step_ > 1 ? kLead_ns : 0);
      named_.shown = frame_.number;
      named_.show_ns = show_ns_;
      link_->Say(named_);
      return;
    }
    link_->Wait(now_ns + 10'000'000);
  }
}

void Walls::AwaitFirst() {
  for (;;) {
    const WallLink::HeardFrame heard = link_->frame();
    const std::int64_t now_ns = core::MonotonicNow_ns();
    if (heard.frame.shown >= frame_.number) {
      show_ns_ = heard.frame.show_ns;
      frame_.is_in_step = heard.frame.shown == frame_.number;  // else the others did not wait for this one
      return;
    }
    const bool is_there = now_ns - heard.heard_ns < Barrier::kSilence_ns;
    if (!is_there || is_stopped_()) {
      frame_.is_in_step = false;
      return;
    }
    link_->Wait(now_ns + Barrier::kSilence_ns);
  }
}

void Walls::Shown() {
  own_.shown = frame_.number;
  own_.shown_ns = core::MonotonicNow_ns();
  link_->Say(own_);
  rows_.push_back({frame_.number, own_.tick, own_.shown_ns, frame_.is_in_step});
  if (link_->place().is_first()) Compare();
}

// The others' messages about the frame before have arrived by now.
void Walls::Compare() {
  if (rows_.size() < 2) return;
  const Row& last = rows_[rows_.size() - 2];
  std::int64_t first_ns = last.shown_ns, latest_ns = last.shown_ns;
  for (const WallLink::HeardState& other : link_->states()) {
    if (other.heard_ns == 0 || other.state.shown != last.frame) continue;
    first_ns = std::min(first_ns, other.state.shown_ns);
    latest_ns = std::max(latest_ns, other.state.shown_ns);
  }
  apart_ms_ = 1e-6 * static_cast<double>(latest_ns - first_ns);
}

std::string Walls::Describe() const {
  const WallPlace& place = link_->place();
  const std::string wall = "wall " + place.walls[place.own] + " of " + place.room;
  if (!place.is_first())
    return wall + (frame_.is_in_step ? "" : ": not in step, nothing is heard of wall " + place.walls[0]);
  char text[64];
  std::snprintf(text, sizeof text, ": %zu of %zu in step, %.1f ms apart", num_in_step_, place.walls.size(), apart_ms_);
  return wall + text;
}

core::Result<void> Walls::Write(const std::filesystem::path& file) const {
  std::ofstream out(file);
  out << "frame,tick,shown_ns,in_step\n";
  for (const Row& row : rows_) {
    out << row.frame << "," << row.tick << "," << row.shown_ns << "," << (row.is_in_step ? 1 : 0) << "\n";
  }
  if (out.flush()) return {};
  return core::Fail(core::ErrorCode::kIo, "cannot write " + file.string() + "; is the folder writable?");
}

}  // namespace visual_node
