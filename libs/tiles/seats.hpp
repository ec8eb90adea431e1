#pragma once

#include <cstddef>
#include <string>

#include "core/result.hpp"

namespace tiles {

// Workers sit on the seats 1 to kMostSeats of a viewer. The worker's name on the bus says which.
constexpr std::size_t kMostSeats = 16;

std::string WorkerName(const std::string& viewer, std::size_t seat);

struct Place {
  std::string viewer;
  std::size_t seat = 0;
};
// Error: kInvalidInput.
core::Result<Place> ReadWorkerName(const std::string& name);

}  // namespace tiles
