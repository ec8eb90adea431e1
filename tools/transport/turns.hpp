#pragma once

#include <sys/types.h>

#include <cstdint>
#include <vector>

#include "bus/rt/latency_stats.hpp"
#include "tools/transport/channel.hpp"

namespace transport {

// Sleeps until that time of CLOCK_MONOTONIC; returns at once if it has passed.
void SleepUntil(std::int64_t time_ns);

struct Hops {
  bus::LatencyStats latency;  // from before Send to after Receive
  std::uint64_t sent = 0;
};

// Every channel carries one message in each `period_ns`, `rounds` times. They take turns, in an order that changes.
// Each has a receiver thread, which sleeps until a message arrives.
std::vector<Hops> TakeTurns(const Channels& channels, std::int64_t rounds, std::int64_t period_ns);

struct Load {
  double sent_per_s = 0.0;
  double received_per_s = 0.0;
};

// One thread sends as fast as it can for that time and another one receives. When this returns, no message is under
// way.
Load Flood(Channel* channel, double seconds);

// Ids of this process's threads, in rising order.
std::vector<pid_t> Threads();

struct Worked {
  Channel* channel = nullptr;
  std::vector<pid_t> threads;  // its own
};

// Processor time [us] of a message at 1 kHz, by channel: that of the sending call, the receiver and the channel's own
// threads over `rounds` messages, minus that of the same threads over an equally long idle time. The channels take
// turns message by message, so that other load on the machine affects all alike. The caller chooses whether sending or
// idle comes first, and should alternate.
std::vector<double> ProcessorTimePerMessage_us(const std::vector<Worked>& channels, std::int64_t rounds,
                                               bool is_idle_first);

}  // namespace transport
