#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "tiles/cost_map.hpp"
#include "tiles/tile.hpp"

namespace tiles {

// A tile that a worker has to draw.
struct Job {
  std::uint64_t id = 0;
  std::uint64_t frame = 0;
  Tile tile;

  bool operator==(const Job&) const = default;
};

// Which worker draws which tile. Workers sit on numbered seats; each has a short list of jobs, which is filled up as it
// answers. A frame's dearest tiles are given out first; when all are given out, the next frame begins, so that nobody
// waits for the last tiles. A tile that is late goes to another worker, too, and the first answer counts. A state
// machine without threads and clocks: time is what the caller says [s], of a clock that does not run backwards.
class Schedule {
 public:
  static constexpr std::size_t kMostJobs = 8;     // on a seat's list
  static constexpr std::size_t kMostFrames = 2;   // in flight
  static constexpr double kAhead_s = 4e-3;        // of work on a list: more than a message there and back takes
  static constexpr double kTilesPerSeat = 10.0;   // of a frame: they end within a tenth of each other
  static constexpr double kLeastTile_s = 1e-3;    // smaller ones would be mostly messages
  static constexpr double kLate = 2.5;            // times as long as expected
  static constexpr double kLateSlack_s = 50e-3;   // and more: what a busy machine may hold a process up
  static constexpr double kPaceShare = 0.3;       // of a new measurement
  static constexpr double kMostPaceGrowth = 3.0;  // by one measurement: a worker that stood still is not slow for ever

  // `first_id`: of jobs; two lives of a leader should not use the same.
  explicit Schedule(std::size_t num_seats, std::uint64_t first_id = 1);

  // A worker has taken the seat, or has left it. Its jobs are void.
  void Join(std::size_t seat, double now_s);
  void Leave(std::size_t seat);
  [[nodiscard]] bool IsTaken(std::size_t seat) const { return seats_[seat].is_taken; }
  [[nodiscard]] std::size_t num_taken() const;

  // A seat would run out of work, and another frame may be begun.
  [[nodiscard]] bool WantsFrame() const;
  // Frames have growing numbers.
  void BeginFrame(std::uint64_t frame, int width, int height, double now_s);
  // Forgets all frames.
  void Clear();

  // A worker's answer. The tile is new when this returns it; none: another worker was faster, or nobody asked for it.
  struct Answer {
    std::uint64_t frame = 0;
    Tile tile;
  };
  std::optional<Answer> Take(std::size_t seat, std::uint64_t job, double cost_s, double now_s);

  // Fills the lists, and gives tiles that are late to others.
  void Update(double now_s);
  [[nodiscard]] const std::vector<Job>& jobs(std::size_t seat) const { return seats_[seat].jobs; }

  // The oldest frame, once, when it is complete.
  std::optional<std::uint64_t> TakeDone();

  [[nodiscard]] std::size_t num_in_flight() const { return frames_.size(); }
  [[nodiscard]] std::uint64_t num_reissued() const { return num_reissued_; }
  [[nodiscard]] std::uint64_t num_unused() const { return num_unused_; }  // answers

 private:
  struct Part {
    Tile tile;
    double cost_s = 0.0;
    bool is_done = false;
    int num_askers = 0;  // lists that it is on
  };
  struct Frame {
    std::uint64_t number = 0;
    int width = 0, height = 0;
    std::vector<Part> parts;         // the dearest first
    std::vector<std::size_t> again;  // that are late
    std::size_t next = 0;            // the first that was never given out
    std::size_t num_done = 0;
  };
  struct Seat {
    bool is_taken = false;
    bool is_late = false;  // gets no more until it answers
    double pace = 1.0;     // how much longer than the tile's cost an answer takes
    double since_s = 0.0;  // since when it works on the first job of the list
    std::vector<Job> jobs;
    std::vector<double> expected_s;  // of each
  };

  [[nodiscard]] double Backlog_s(const Seat& seat) const;
  Frame* Find(std::uint64_t number);
  Part* Find(const Job& job);
  void GiveUp(Seat* seat);
  void FindLate(double now_s);
  void Drop(std::size_t seat, std::size_t place, double now_s);
  bool GiveNext(std::size_t seat, double now_s);
  void GiveCopy(std::size_t seat, double now_s);
  void Give(std::size_t seat, Frame* frame, std::size_t part, double now_s);

  CostMap costs_;
  std::vector<Seat> seats_;
  std::deque<Frame> frames_;
  std::uint64_t next_id_;
  std::uint64_t num_reissued_ = 0;
  std::uint64_t num_unused_ = 0;
};

}  // namespace tiles
