#include "tools/transport/turns.hpp"

#include <atomic>
#include <ctime>
#include <numeric>
#include <random>
#include <thread>

#include "core/clock.hpp"
#include "tools/bench/one_core.hpp"

namespace transport {
namespace {

void SleepUntil(std::int64_t time_ns) {
  const timespec until{time_ns / core::kNanosecondsPerSecond, time_ns % core::kNanosecondsPerSecond};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

double ProcessorTime_us() {
  timespec used{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
  return 1e6 * static_cast<double>(used.tv_sec) + 1e-3 * static_cast<double>(used.tv_nsec);
}

// Receives until told to end.
class Receiver {
 public:
  Receiver(Channel* channel, bus::LatencyStats* latency)
      : thread_([this, channel, latency] {
          while (!is_done_.load(std::memory_order_relaxed)) {
            const std::int64_t sent_ns = channel->Receive();
            if (sent_ns == 0) continue;
            if (latency != nullptr) latency->Add(core::MonotonicNow_ns() - sent_ns);
            num_received_.fetch_add(1, std::memory_order_relaxed);
          }
        }) {}
  ~Receiver() {
    is_done_.store(true);
    thread_.join();
  }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;
  [[nodiscard]] std::uint64_t num_received() const { return num_received_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> is_done_{false};
  std::atomic<std::uint64_t> num_received_{0};
  std::thread thread_;
};

}  // namespace

std::vector<Hops> TakeTurns(const Channels& channels, std::int64_t rounds, std::int64_t period_ns) {
  std::vector<Hops> hops(channels.size());
  {
    std::vector<std::unique_ptr<Receiver>> receivers;
    for (std::size_t i = 0; i < channels.size(); ++i) {
      receivers.push_back(std::make_unique<Receiver>(channels[i].get(), &hops[i].latency));
    }
    std::vector<std::size_t> order(channels.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::mt19937_64 random(1);
    const std::int64_t turn_ns = period_ns / static_cast<std::int64_t>(channels.size());
    std::int64_t next_ns = core::MonotonicNow_ns();
    for (std::int64_t round = 0; round < rounds; ++round) {
      for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
      for (const std::size_t which : order) {
        next_ns += turn_ns;
        SleepUntil(next_ns);
        if (channels[which]->Send(core::MonotonicNow_ns())) ++hops[which].sent;
      }
    }
    SleepUntil(core::MonotonicNow_ns() + 20'000'000);  // what is on its way
  }
  return hops;
}

Load Flood(Channel* channel, double seconds) {
  const auto length_ns = static_cast<std::int64_t>(1e9 * seconds);
  std::uint64_t sent = 0;
  const Receiver receiver(channel, nullptr);
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  std::int64_t now_ns = begin_ns;
  while ((now_ns = core::MonotonicNow_ns()) < begin_ns + length_ns) sent += channel->Send(now_ns) ? 1 : 0;
  const double took_s = 1e-9 * static_cast<double>(now_ns - begin_ns);
  return {static_cast<double>(sent) / took_s, static_cast<double>(receiver.num_received()) / took_s};
}

double ProcessorTimePerMessage_us(Channel* channel, std::int64_t rounds) {
  constexpr int kTurns = 9;
  const Receiver receiver(channel, nullptr);
  const auto run = [&](bool sends) {
    const double before_us = ProcessorTime_us();
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    for (std::int64_t round = 1; round <= rounds; ++round) {
      SleepUntil(begin_ns + round * core::kTick_ns);
      if (sends) channel->Send(core::MonotonicNow_ns());
    }
    return (ProcessorTime_us() - before_us) / static_cast<double>(rounds);
  };
  std::vector<double> costs_us;
  for (int turn = 0; turn < kTurns; ++turn) {
    const double idle_us = run(false);
    costs_us.push_back(run(true) - idle_us);
  }
  return bench::Quantile(costs_us, 0.5);
}

}  // namespace transport
