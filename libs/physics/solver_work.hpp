#pragma once

#include <cstdint>

namespace physics {

// Work of the solver since its world was created, in exact numbers, so that tests can detect unnecessary work. Bodies
// without contacts or joints add none.
struct SolverWork {
  std::uint64_t num_islands = 0;  // groups of bodies that are joined by rows, summed over the steps
  std::uint64_t num_rows = 0;     // of joints, contacts and friction, summed over the steps
  std::uint64_t num_sweeps = 0;   // Gauss-Seidel passes over an island
  std::uint64_t num_row_updates = 0;
  std::uint64_t num_direct_solves = 0;
  std::uint64_t num_fallbacks = 0;  // islands left with a residual above 1e-6 m/s
};

}  // namespace physics
