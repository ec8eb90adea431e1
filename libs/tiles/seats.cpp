#include "tiles/seats.hpp"

#include <charconv>

namespace tiles {
namespace {

const std::string kProgram = "rt_worker-";

}  // namespace

std::string WorkerName(const std::string& viewer, std::size_t seat) {
  return kProgram + viewer + "-" + std::to_string(seat);
}

core::Result<Place> ReadWorkerName(const std::string& name) {
  const std::size_t dash = name.rfind('-');
  if (name.starts_with(kProgram) && dash != std::string::npos && dash > kProgram.size()) {
    Place place{name.substr(kProgram.size(), dash - kProgram.size()), 0};
    const char* const end = name.data() + name.size();
    const auto read = std::from_chars(name.data() + dash + 1, end, place.seat);
    if (read.ec == std::errc() && read.ptr == end && place.seat >= 1 && place.seat <= kMostSeats) return place;
  }
  return core::Fail(core::ErrorCode::kInvalidInput, "a worker is named " + kProgram +
                                                        "VIEWER-SEAT with a seat from 1 to " +
                                                        std::to_string(kMostSeats) + ", not '" + name + "'");
}

}  // namespace tiles
