#pragma once

#include <cstdint>

namespace core {

// Nanoseconds on CLOCK_MONOTONIC: the only clock that latencies are taken from. Never wall time.
std::int64_t MonotonicNow_ns();
// Time that a core has spent on the calling thread: what work costs, also while others keep the core busy.
std::int64_t ThreadCpuNow_ns();

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
constexpr std::int64_t kTick_ns = 1'000'000;  // 1 kHz, the haptic and dynamics period [VR-OOS, section 3]
constexpr double kTick_s = 1e-3;

}  // namespace core
