#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <thread>

#include "core/result.hpp"
#include "space/atmosphere/from_space.hpp"

namespace visual_node {

// The Earth's air as the cache has it. Error: what is missing in pictures without it, and how to get it.
core::Result<space::AirFromSpace> CachedAir(const space::AirTableSizes& sizes = {});

// Computes the air in a thread that runs only when nothing else wants to, and puts it into the cache. Its end stops the
// work.
class AirInWork {
 public:
  explicit AirInWork(const space::AirTableSizes& sizes = {});
  ~AirInWork();
  AirInWork(const AirInWork&) = delete;
  AirInWork& operator=(const AirInWork&) = delete;

  // Once, when it is done.
  std::optional<space::AirFromSpace> Take();

 private:
  void Work();

  const space::AirTableSizes sizes_;
  std::atomic<bool> is_stop_wanted_{false};
  std::atomic<bool> is_done_{false};
  std::optional<space::AirFromSpace> air_;  // belongs to the thread until it is done
  std::thread thread_;
};

}  // namespace visual_node
