#pragma once

#include <cstdint>

namespace physics {

// What the solver has done since its world was made; exact, so that work that should not be there fails a test.
// Parts that nothing touches add nothing.
struct SolverWork {
  std::uint64_t num_islands = 0;  // groups of bodies that are joined by rows, summed over the steps
  std::uint64_t num_rows = 0;     // of joints, contacts and friction, summed over the steps
  std::uint64_t num_sweeps = 0;   // passes of sequential impulses over an island
  std::uint64_t num_row_updates = 0;
  std::uint64_t num_direct_solves = 0;
  std::uint64_t num_fallbacks = 0;  // islands left wrong by more than 1e-6 m/s
};

}  // namespace physics
