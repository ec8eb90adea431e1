#pragma once

#include <cstdint>
#include <vector>

#include "bus/rt/latency_stats.hpp"
#include "tools/transport/channel.hpp"

namespace transport {

struct Hops {
  bus::LatencyStats latency;  // from before Send to after Receive
  std::uint64_t sent = 0;
};

// Every channel carries a message once in `period_ns`, `rounds` times; they take turns in an order that changes, so
// that all see the same machine and nobody always follows the same other one. Each has a receiver's thread that sleeps.
std::vector<Hops> TakeTurns(const Channels& channels, std::int64_t rounds, std::int64_t period_ns);

struct Load {
  double sent_per_s = 0.0;
  double received_per_s = 0.0;
};

// As fast as one thread can send for so long, to one that receives.
Load Flood(Channel* channel, double seconds);

// Processor time [us] of all threads of this process for a message at 1 kHz, without that of the same time idle: median
// of nine turns of so many rounds, sending and idle.
double ProcessorTimePerMessage_us(Channel* channel, std::int64_t rounds);

}  // namespace transport
