#pragma once

#include <string>

namespace bus {

// Real-time scheduling: off, best effort, or required.
enum class RealTimeMode { kOff, kTry, kEnforce };

// "off", "try" or "enforce"; false for anything else.
bool ParseRealTimeMode(const std::string& text, RealTimeMode* mode);

struct ThreadSetup {
  std::string name;  // at most 15 characters are kept
  RealTimeMode mode = RealTimeMode::kTry;
  int fifo_priority = 80;    // SCHED_FIFO, 1 to 99
  bool locks_memory = true;  // mlockall: no page fault in a step
  int nice = 0;              // used when FIFO is off or not granted; positive is lower priority
};

// What was granted, and the reason where it was not.
struct ThreadReport {
  bool is_fifo = false;
  bool is_memory_locked = false;
  bool flushes_denormals = false;
  bool is_ok = true;  // false only in mode kEnforce, when FIFO or locked memory was not granted
  std::string text;   // one line for the node's log, with the remedy
};

// For the calling thread. Denormal numbers are flushed to zero in every mode (they cost a hundred cycles each and
// decaying filters produce them), timer slack is 1 ns instead of 50 us.
ThreadReport SetUpThread(const ThreadSetup& setup);

}  // namespace bus
