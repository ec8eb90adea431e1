#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "nodes/lockstep/lockstep.hpp"

namespace system_tests {

// Counts allocations, locks and log lines in the steps of the nodes of a lock-step run. The first steps of each node
// allocate its buffers and are not counted.
class StepWatch {
 public:
  static constexpr std::uint64_t kWarmSteps = 1000;

  struct Steps {
    std::uint64_t count = 0;  // the first ones included
    std::uint64_t dirty = 0;
    std::uint64_t allocations = 0;  // and releases
    std::uint64_t locks = 0;
    std::uint64_t logs = 0;
    std::string first;  // where the first dirty one did it
  };

  // Counts in the runs of these options; must outlive them.
  void Watch(lockstep::Options* options);
  [[nodiscard]] const Steps& of(std::string_view node) const;
  // False in sanitizer builds, which have an allocator of their own.
  static bool is_possible();

 private:
  void End(Steps* steps);

  std::map<std::string, Steps, std::less<>> steps_;
};

}  // namespace system_tests
