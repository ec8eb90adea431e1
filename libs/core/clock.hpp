#pragma once

#include <cstdint>

namespace core {

// CLOCK_MONOTONIC [ns]. All latencies are differences of this clock, never of wall time.
std::int64_t MonotonicNow_ns();
// CPU time of the calling thread, CLOCK_THREAD_CPUTIME_ID [ns]: leaves out the time in which other threads hold the
// core.
std::int64_t ThreadCpuNow_ns();

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
constexpr std::int64_t kMillisecond_ns = 1'000'000;
constexpr std::int64_t kTick_ns = 1'000'000;  // 1 kHz, the haptic and dynamics period [VR-OOS, section 3]
constexpr double kTick_s = 1e-3;              // the same period

}  // namespace core
