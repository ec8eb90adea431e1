#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "bus/node.hpp"
#include "core/messages/rays.hpp"
#include "core/result.hpp"
#include "tiles/pixels.hpp"
#include "tiles/refinement.hpp"
#include "tiles/schedule.hpp"
#include "tiles/seats.hpp"
#include "view/scene.hpp"
#include "view/stereo.hpp"

namespace rt_visual_node {

// A frame that workers are to draw, with what is drawn over their light.
struct Wish {
  core::RayFrame frame;
  view::Scene scene;
  scene::Camera camera;  // in W
  view::Viewing viewing{};
  std::vector<tiles::Tile> parts{};  // of the picture: what each eye sees
  std::uint64_t number = 0;          // of a picture that is waited for; 0: the next of those that are shown
  [[nodiscard]] bool is_awaited() const { return number != 0; }
};

// A frame that they have drawn.
struct Drawn {
  Wish wish;
  tiles::Canvas canvas;
  std::int64_t begin_ns = 0;  // its tiles were given out from then on
  std::int64_t end_ns = 0;
  double cost_s = 0.0;  // of a core, of all its tiles
  std::uint64_t digest = 0;
};

// Gives tiles to workers and puts their answers together, in a thread of its own with its own end of the bus: what
// shows the picture does not hold it up, and tiles do not hold up what the viewer reads.
class Exchange {
 public:
  struct Figures {
    std::size_t workers = 0;
    std::uint64_t begun = 0;   // frames
    std::uint64_t frames = 0;  // that are complete
    std::uint64_t tiles = 0;
    std::uint64_t reissued = 0;
    std::uint64_t unused = 0;
    std::uint64_t bytes = 0;  // of all answers
    double cost_s = 0.0;      // of a core, of all frames
  };

  // `options` are the viewer's: the exchange's name is the viewer's with "-tiles".
  explicit Exchange(const bus::NodeOptions& options) : options_(options) {}
  ~Exchange() { Stop(); }
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

  // Does not wait for the registry's answer; while there is none there are no workers.
  core::Result<void> Start();
  void Stop();
  // After Stop: why it never was on the bus; empty: it was.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }

  // --- Drawing thread. The next frame is this one, unless another wish replaces it before. A wish that is like the
  // last frame makes its picture better, if it can be better.
  void Want(Wish wish);
  // The newest complete frame, once; waits for it until a time [ns, CLOCK_MONOTONIC]. Null: none.
  std::unique_ptr<Drawn> Take(std::int64_t deadline_ns);
  [[nodiscard]] bool has_workers() const { return num_workers_.load(std::memory_order_relaxed) > 0; }
  [[nodiscard]] Figures figures() const;
  [[nodiscard]] const bus::Node& node() const { return *node_; }

 private:
  struct Seat {
    std::string worker;
    bus::LatestWriter<core::RayJobs> jobs;
    bus::StateReader<core::RayTile>* tiles = nullptr;
    std::map<std::string, std::uint64_t> seen;  // the newest job of each key
    std::vector<tiles::Job> sent;
    std::int64_t sent_ns = 0;
  };

  void Run();
  void TakeEvents();
  void TakeTiles();
  void TakeTile(std::size_t seat, const core::RayTile& tile);
  void BeginFrames();
  std::unique_ptr<Drawn> NextFrame();
  void SendJobs();
  void Finish(std::uint64_t frame);

  bus::NodeOptions options_;
  std::unique_ptr<bus::Node> node_;
  bus::StateWriter<core::RayFrame> frames_out_;
  std::array<Seat, tiles::kMostSeats> seats_;
  std::set<std::string> alive_;
  std::unique_ptr<tiles::Schedule> schedule_;
  std::map<std::uint64_t, std::unique_ptr<Drawn>> in_flight_;
  std::uint64_t next_frame_ = 0;
  tiles::Refinement refinement_;

  mutable std::mutex mutex_;
  std::condition_variable is_done_;
  std::optional<Wish> wish_;
  std::unique_ptr<Drawn> done_;
  std::unique_ptr<Drawn> spare_;  // its buffers
  Figures figures_;
  std::atomic<std::size_t> num_workers_{0};
  std::atomic<bool> is_stopping_{false};
  std::string trouble_;
  std::thread thread_;
};

}  // namespace rt_visual_node
