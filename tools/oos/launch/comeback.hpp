#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tools/oos/launch/watch.hpp"

namespace oos {

// Handles hosts of a run that fall silent, by a long outage of the link or a power cut: connects again, has their
// supervisors restart what has ended, and continues to read their logs.
class Comebacks {
 public:
  struct Host {
    std::string root;    // run folder of the host
    std::string resume;  // lab::UnitFiles::resume, with the run's environment
    std::vector<std::string> units;
  };
  Comebacks(std::string run, std::vector<Host> hosts, Remotes* remotes, LogStreams* streams)
      : run_(std::move(run)),
        hosts_(std::move(hosts)),
        since_ns_(hosts_.size(), 0),
        remotes_(remotes),
        streams_(streams) {}

  // Call it periodically. `say` receives host and text. Returns why the run cannot go on; empty if it can.
  std::string Poll(const std::function<void(const std::string&, const std::string&)>& say);
  [[nodiscard]] bool was_stopped() const { return was_stopped_; }  // from elsewhere, while a host was silent

 private:
  std::string Resume(std::size_t host);

  std::string run_;
  std::vector<Host> hosts_;
  std::vector<std::int64_t> since_ns_;  // silent since; 0: it is not
  Remotes* remotes_;
  LogStreams* streams_;
  std::int64_t next_ns_ = 0;
  bool was_stopped_ = false;
};

}  // namespace oos
