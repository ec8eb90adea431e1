#include "tiles/schedule.hpp"

#include <algorithm>
#include <numeric>

namespace tiles {

Schedule::Schedule(std::size_t num_seats, std::uint64_t first_id) : seats_(num_seats), next_id_(first_id) {}

void Schedule::Join(std::size_t seat, double now_s) {
  Leave(seat);
  seats_[seat].is_taken = true;
  seats_[seat].since_s = now_s;
}

void Schedule::Leave(std::size_t seat) {
  GiveUp(&seats_[seat]);
  seats_[seat] = Seat{};
}

std::size_t Schedule::num_taken() const {
  return static_cast<std::size_t>(
      std::count_if(seats_.begin(), seats_.end(), [](const Seat& seat) { return seat.is_taken; }));
}

// Whatever only this seat was asked for is asked for again.
void Schedule::GiveUp(Seat* seat) {
  for (const Job& job : seat->jobs) {
    Frame* frame = Find(job.frame);
    Part* part = Find(job);
    if (part == nullptr || part->is_done || --part->num_askers > 0) continue;
    frame->again.push_back(static_cast<std::size_t>(part - frame->parts.data()));
    ++num_reissued_;
  }
  seat->jobs.clear();
  seat->expected_s.clear();
}

double Schedule::Backlog_s(const Seat& seat) const {
  return std::accumulate(seat.expected_s.begin(), seat.expected_s.end(), 0.0);
}

bool Schedule::WantsFrame() const {
  if (frames_.size() >= kMostFrames) return false;
  for (const Frame& frame : frames_) {
    if (frame.next < frame.parts.size() || !frame.again.empty()) return false;
  }
  return std::any_of(seats_.begin(), seats_.end(), [this](const Seat& seat) {
    return seat.is_taken && !seat.is_late && seat.jobs.size() < kMostJobs && Backlog_s(seat) < kAhead_s;
  });
}

void Schedule::BeginFrame(std::uint64_t number, int width, int height, double now_s) {
  Frame frame{.number = number, .width = width, .height = height, .parts = {}, .again = {}};
  const double all_s = costs_.Of({0, 0, width, height}, width, height);
  const double share_s = all_s / (kTilesPerSeat * static_cast<double>(std::max<std::size_t>(num_taken(), 1)));
  for (const Tile& tile : CutIntoTiles(costs_, width, height, std::max(share_s, kLeastTile_s))) {
    frame.parts.push_back({.tile = tile, .cost_s = costs_.Of(tile, width, height)});
  }
  frames_.push_back(std::move(frame));
  Update(now_s);
}

void Schedule::Clear() {
  frames_.clear();
  for (Seat& seat : seats_) {
    seat.jobs.clear();
    seat.expected_s.clear();
    seat.is_late = false;
  }
}

Schedule::Frame* Schedule::Find(std::uint64_t number) {
  const auto found =
      std::find_if(frames_.begin(), frames_.end(), [&](const Frame& frame) { return frame.number == number; });
  return found == frames_.end() ? nullptr : &*found;
}

Schedule::Part* Schedule::Find(const Job& job) {
  Frame* frame = Find(job.frame);
  if (frame == nullptr) return nullptr;
  const auto found =
      std::find_if(frame->parts.begin(), frame->parts.end(), [&](const Part& part) { return part.tile == job.tile; });
  return found == frame->parts.end() ? nullptr : &*found;
}

// Takes a job off a list.
void Schedule::Drop(std::size_t seat, std::size_t place, double now_s) {
  Seat& at = seats_[seat];
  if (place == 0) at.since_s = now_s;
  if (Part* part = Find(at.jobs[place]); part != nullptr) --part->num_askers;
  at.jobs.erase(at.jobs.begin() + static_cast<std::ptrdiff_t>(place));
  at.expected_s.erase(at.expected_s.begin() + static_cast<std::ptrdiff_t>(place));
}

std::optional<Schedule::Answer> Schedule::Take(std::size_t seat, std::uint64_t id, double cost_s, double now_s) {
  Seat& at = seats_[seat];
  at.is_late = false;
  const auto found = std::find_if(at.jobs.begin(), at.jobs.end(), [&](const Job& job) { return job.id == id; });
  if (found == at.jobs.end()) {
    at.since_s = now_s;
    ++num_unused_;
    return std::nullopt;
  }
  const Job job = *found;
  if (cost_s > 0.0) {
    const double pace = std::min((now_s - at.since_s) / cost_s, kMostPaceGrowth * at.pace);
    at.pace += kPaceShare * (std::max(pace, 1.0) - at.pace);
  }
  at.since_s = now_s;
  Drop(seat, static_cast<std::size_t>(found - at.jobs.begin()), now_s);
  Frame* frame = Find(job.frame);
  Part* part = Find(job);
  if (part == nullptr || part->is_done) {
    ++num_unused_;
    return std::nullopt;
  }
  part->is_done = true;
  ++frame->num_done;
  costs_.Take(job.tile, frame->width, frame->height, cost_s);
  // Others need not begin with it any more; one that has begun will answer in vain.
  for (std::size_t other = 0; other < seats_.size() && part->num_askers > 0; ++other) {
    const std::vector<Job>& jobs = seats_[other].jobs;
    for (std::size_t i = jobs.size(); i-- > 0;) {
      if (jobs[i].frame == job.frame && jobs[i].tile == job.tile) Drop(other, i, now_s);
    }
  }
  return Answer{job.frame, job.tile};
}

// Expected is what the first job of a list takes from when the seat answered last, or got it.
void Schedule::FindLate(double now_s) {
  for (Seat& seat : seats_) {
    if (!seat.is_taken || seat.is_late || seat.jobs.empty()) continue;
    if (now_s - seat.since_s <= kLate * seat.expected_s.front() + kLateSlack_s) continue;
    seat.is_late = true;
    for (const Job& job : seat.jobs) {
      Frame* frame = Find(job.frame);
      Part* part = Find(job);
      if (part == nullptr || part->is_done || part->num_askers > 1) continue;
      frame->again.push_back(static_cast<std::size_t>(part - frame->parts.data()));
      ++num_reissued_;
    }
  }
}

void Schedule::Give(std::size_t seat, Frame* frame, std::size_t part, double now_s) {
  Seat& at = seats_[seat];
  Part& given = frame->parts[part];
  if (at.jobs.empty()) at.since_s = now_s;
  at.jobs.push_back({next_id_++, frame->number, given.tile});
  at.expected_s.push_back(at.pace * given.cost_s);
  ++given.num_askers;
}

// The next tile that somebody must draw, unless this seat has been asked for it already. False: none.
bool Schedule::GiveNext(std::size_t seat, double now_s) {
  for (Frame& frame : frames_) {
    for (std::size_t i = 0; i < frame.again.size(); ++i) {
      const std::size_t part = frame.again[i];
      const std::vector<Job>& jobs = seats_[seat].jobs;
      const bool is_its_own = std::any_of(jobs.begin(), jobs.end(), [&](const Job& job) {
        return job.frame == frame.number && job.tile == frame.parts[part].tile;
      });
      if (is_its_own) continue;
      frame.again.erase(frame.again.begin() + static_cast<std::ptrdiff_t>(i));
      if (frame.parts[part].is_done) {
        --i;
        continue;
      }
      Give(seat, &frame, part, now_s);
      return true;
    }
    if (frame.next < frame.parts.size()) {
      Give(seat, &frame, frame.next++, now_s);
      return true;
    }
  }
  return false;
}

void Schedule::Update(double now_s) {
  FindLate(now_s);
  for (;;) {  // whoever has least to do comes first
    std::size_t least = seats_.size();
    double least_s = kAhead_s;
    for (std::size_t i = 0; i < seats_.size(); ++i) {
      const Seat& seat = seats_[i];
      if (!seat.is_taken || seat.is_late || seat.jobs.size() >= kMostJobs || Backlog_s(seat) >= least_s) continue;
      least = i;
      least_s = Backlog_s(seat);
    }
    if (least == seats_.size() || !GiveNext(least, now_s)) break;
  }
  for (std::size_t i = 0; i < seats_.size(); ++i) {
    if (seats_[i].is_taken && seats_[i].is_late && seats_[i].jobs.empty()) GiveCopy(i, now_s);
  }
}

// To find out whether a late seat is back: a tile that somebody else draws as well, so that nobody waits for it.
void Schedule::GiveCopy(std::size_t seat, double now_s) {
  for (Frame& frame : frames_) {
    for (std::size_t part = 0; part < frame.next; ++part) {
      if (frame.parts[part].is_done || frame.parts[part].num_askers == 0) continue;
      Give(seat, &frame, part, now_s);
      return;
    }
  }
}

std::optional<std::uint64_t> Schedule::TakeDone() {
  if (frames_.empty() || frames_.front().num_done < frames_.front().parts.size()) return std::nullopt;
  const std::uint64_t number = frames_.front().number;
  frames_.pop_front();
  return number;
}

}  // namespace tiles
