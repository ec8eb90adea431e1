#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <queue>
#include <set>
#include <vector>

#include "tiles/schedule.hpp"

namespace tiles {

// How long each place of the pictures of a run took [s of a core]: squares of 32 pixels, row by row, for each frame.
struct RecordedCosts {
  static constexpr int kSquare = 32;
  int width = 0, height = 0;
  std::vector<std::vector<double>> frames;

  // A file of text: "WIDTH HEIGHT", then a line for each frame of whole microseconds.
  static RecordedCosts Read(const std::filesystem::path& file);
  [[nodiscard]] double Of(std::size_t frame, const Tile& tile) const;
};

// Workers that take as long as was recorded, on a clock of their own. Each answers its list of jobs in order; a message
// takes `message_s` either way.
class Emulation {
 public:
  Emulation(const RecordedCosts* costs, std::size_t num_workers, double message_s, double per_tile_s);

  // Until so many more frames are complete.
  void RunFrames(std::size_t frames);
  void RunUntil(double time_s);

  // From now on.
  void Kill(std::size_t worker);  // and nobody is told
  void Stop(std::size_t worker);  // as Kill, until Continue
  void Continue(std::size_t worker);
  void Slow(std::size_t worker, double times);
  void Join(std::size_t worker);

  [[nodiscard]] double now_s() const { return now_s_; }
  [[nodiscard]] Schedule& schedule() { return schedule_; }
  // When each frame was complete.
  [[nodiscard]] const std::vector<double>& done_s() const { return done_s_; }
  [[nodiscard]] double work_s() const { return work_s_; }  // of all tiles that were of use, at full speed
  // Frames a second between two times.
  [[nodiscard]] double Rate(double begin_s, double end_s) const;

 private:
  struct Event {
    double time_s;
    std::uint64_t order;
    std::function<void()> act;
    bool operator<(const Event& other) const {
      return time_s != other.time_s ? time_s > other.time_s : order > other.order;
    }
  };
  struct Worker {
    bool is_running = true;
    double times = 1.0;
    std::vector<Job> list;  // the newest that has arrived
    std::set<std::uint64_t> begun;
    bool is_busy = false;
    std::optional<Job> frozen;  // in the middle of it
  };
  void At(double time_s, std::function<void()> act) { events_.push({time_s, num_events_++, std::move(act)}); }
  void Pump();
  void Begin(std::size_t worker);
  void End(std::size_t worker, const Job& job);
  void Step();

  const RecordedCosts* costs_;
  double message_s_, per_tile_s_;
  Schedule schedule_;
  std::vector<Worker> workers_;
  std::vector<std::vector<Job>> sent_;
  std::priority_queue<Event> events_;
  std::uint64_t num_events_ = 0;
  std::uint64_t next_frame_ = 0;
  double now_s_ = 0.0, work_s_ = 0.0;
  std::vector<double> done_s_;
};

}  // namespace tiles
