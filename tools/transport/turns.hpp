#pragma once

#include <sys/types.h>

#include <cstdint>
#include <vector>

#include "bus/rt/latency_stats.hpp"
#include "tools/transport/channel.hpp"

namespace transport {

// Until then by CLOCK_MONOTONIC; comes back at once when it is over.
void SleepUntil(std::int64_t time_ns);

struct Hops {
  bus::LatencyStats latency;  // from before Send to after Receive
  std::uint64_t sent = 0;
};

// Every channel carries a message once in `period_ns`, `rounds` times; they take turns in an order that changes. Each
// has a receiver's thread that sleeps.
std::vector<Hops> TakeTurns(const Channels& channels, std::int64_t rounds, std::int64_t period_ns);

struct Load {
  double sent_per_s = 0.0;
  double received_per_s = 0.0;
};

// As fast as one thread can send for so long, to one that receives. Afterwards nothing is on its way.
Load Flood(Channel* channel, double seconds);

// Ids of this process's threads, in rising order.
std::vector<pid_t> Threads();

struct Worked {
  Channel* channel = nullptr;
  std::vector<pid_t> threads;  // its own
};

// Processor time [us] of a message at 1 kHz by channel, without that of the same time idle: so many rounds sending and
// as many idle. It is that of the call which sends, of the receiver and of the channel's own threads. The channels take
// turns message by message, so that what the machine does meanwhile costs all the same. Which of sending and idle comes
// first is the caller's choice: not always the same.
std::vector<double> ProcessorTimePerMessage_us(const std::vector<Worked>& channels, std::int64_t rounds,
                                               bool is_idle_first);

}  // namespace transport
