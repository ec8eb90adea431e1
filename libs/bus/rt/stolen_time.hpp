#pragma once

namespace bus {

// Time that the processors of this virtual machine had work for and the host gave to others, since boot, summed over
// all processors [s]; 0 on a machine of its own. Reads a file: not in a real-time step.
double StolenTime_s();

}  // namespace bus
