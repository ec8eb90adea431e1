#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace core {

// logic/status (STATE): what the procedure shows to viewers and to the run's report.
struct LampState {
  std::uint16_t object = 0;
  float red = 0, green = 0, blue = 0;
};

struct LogicStatus {
  std::int64_t time_ns = 0;  // bus time
  std::string step;          // active procedure step, e.g. "switch_off"
  std::string hint;          // caption for people
  std::vector<std::string> active_states;
  std::vector<LampState> lamps;
  bool is_final = false;
  bool is_failed = false;
  std::string why;  // when failed: which step and why
};

// When a figure takes its new value: in the owner's next tick; linearly over ramp_s from there; or held until the
// change gives the scene no energy.
enum class ChangeManner : std::uint8_t { kAtOnce = 0, kRamped = 1, kWhenSeparated = 2 };

// param/set (SERVICE): NODE.PARAM VALUE, applied by the owner at the top of its next tick and acknowledged with it.
struct ParameterChange {
  std::string name;  // e.g. "latch_a.release_force_N", "pair.module_old/cavity.active", "force_cap_N"
  double value = 0.0;
  ChangeManner manner = ChangeManner::kAtOnce;
  double ramp_s = 0.0;
};

// event (EVENT): attach and detach, engage and release, node lost and found, faults.
struct Event {
  std::int64_t time_ns = 0;
  std::string source;
  std::string name;
  std::string detail;
};

}  // namespace core
