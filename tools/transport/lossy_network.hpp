#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/result.hpp"

namespace transport {

// Two networks joined by a pair of virtual interfaces. The packet filter of the second one drops arriving packets at
// random. The networks disappear with their last file and socket. Needs root.
class LossyNetwork {
 public:
  static constexpr const char* kNearAddress = "10.79.0.1";
  static constexpr const char* kFarAddress = "10.79.0.2";

  // Errors: kUnsupported, with what this machine lacks.
  static core::Result<std::unique_ptr<LossyNetwork>> Make();
  ~LossyNetwork();
  LossyNetwork(const LossyNetwork&) = delete;
  LossyNetwork& operator=(const LossyNetwork&) = delete;

  // Sockets and threads that begin in `body` belong to that network.
  void DoNear(const std::function<void()>& body) const { Do(near_fd_, body); }
  void DoFar(const std::function<void()>& body) const { Do(far_fd_, body); }
  // Packets to drop of 1000 that arrive in the far network. False if the filter refused.
  bool Lose(int per_mille) const;

 private:
  LossyNetwork() = default;
  static void Do(int fd, const std::function<void()>& body);
  // Empty, or the output of the command if it failed.
  static std::string RunIn(int fd, const std::string& command);
  int near_fd_ = -1, far_fd_ = -1;
};

}  // namespace transport
