#pragma once

#include <cstdint>

#include "core/pose.hpp"
#include "vps/surface/surface_memory.hpp"

namespace vps {

// Of a pair from query to query.
struct TouchMemory {
  std::uint32_t coarseness = 0;  // of the samples that suffice (CookedObject::SamplesAt)
  int queries_to_coarser = 0;    // before coarser ones are tried again
  SurfaceMemory touch;
  // Where the samples alone counted beside the surface: its error, and how often it is not read for that.
  double hopeless_error_m3 = 0.0;
  int queries_to_surface = 0;
  // While nothing touches: no place of S has to be read before one has moved by apart_m since the pose X_GS.
  SurfaceMemory apart;  // of the queries that prove it
  core::Pose X_GS;
  double apart_m = 0.0;
  double offset_m = 1e9;  // to be tried next
  int queries_to_wait = 0;
};

}  // namespace vps
