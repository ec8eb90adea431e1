#pragma once

#include <cstdint>

namespace physics {

// How the number of cells changes a cloth's sag and cost: a square sheet of 0.25 m, held along its middle line as if
// laid over a wire, both halves hanging at 1 g, until it is at rest. Deterministic; the caller measures the time.
struct DrapeResult {
  int num_nodes = 0;
  std::uint64_t num_steps = 0;  // of 1 ms
  double sag_m = 0.0;           // mean depth of the free edges below the wire
  double speed_m_per_s = 0.0;   // largest speed of any node at the end: the residual motion
};

constexpr double kDrapeSide_m = 0.25;
constexpr double kDrapeWeight_N_per_m2 = 0.6 * 9.81;
constexpr double kDrapeBendingStiffness_Nm = 3e-3;

// `cells` along each side, even, at least 4.
DrapeResult Drape(int cells);

}  // namespace physics
