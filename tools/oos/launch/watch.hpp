#pragma once

#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "tools/oos/attach/remote.hpp"

namespace oos {

// Follows the logs of a run on all its hosts.
class LogStreams {
 public:
  // A line of a log: host, unit (the log's name without .log), text.
  using TakeLine = std::function<void(const std::string&, const std::string&, const std::string&)>;

  // `units`: of each host, in the order of the hosts.
  core::Result<void> Open(const std::string& run, const std::vector<std::string>& roots,
                          const std::vector<std::vector<std::string>>& units, Remotes* remotes);
  // Reads a host's logs again after an outage: the registry's from where it broke off, so that no event of the bus is
  // missed; the others from now on.
  core::Result<void> Reopen(std::size_t host, const std::string& run, const std::string& root,
                            const std::vector<std::string>& units, Remotes* remotes);
  // Waits at most `timeout_ms` for lines.
  void Poll(int timeout_ms, const TakeLine& take);
  void Close();
  [[nodiscard]] bool has_ended(std::size_t host) const;

 private:
  struct Stream {
    std::string host, unit;
    std::unique_ptr<PipedChild> child;      // null: nothing runs there
    std::unique_ptr<PipedChild> bus_child;  // of the registry's log, once it was broken off; null: `child` has it
    std::size_t num_bus_lines = 0;          // taken of it
  };
  static void TakeLines(Stream* stream, PipedChild* child, std::string* unit, const TakeLine& take);
  std::vector<Stream> streams_;  // in the order of the hosts
};

// The state of the run as the registry's log reports it.
class BusStory {
 public:
  // Processes a line; returns its text for people, empty if there is none.
  std::string Take(const std::string& line);

  [[nodiscard]] const std::set<std::string>& ready() const { return ready_; }
  [[nodiscard]] bool is_down() const { return is_down_; }  // the registry has ended, and not come back
  [[nodiscard]] bool runs() const { return runs_; }        // the procedure has begun, so all nodes are ready
  [[nodiscard]] bool is_final() const { return is_final_; }
  [[nodiscard]] bool is_failed() const { return is_failed_; }
  [[nodiscard]] const std::string& step() const { return step_; }
  [[nodiscard]] const std::string& why() const { return why_; }
  [[nodiscard]] const std::string& refusal() const { return refusal_; }

 private:
  std::set<std::string> ready_;
  bool is_down_ = false, runs_ = false, is_final_ = false, is_failed_ = false;
  std::string step_, why_, refusal_;
};

}  // namespace oos
