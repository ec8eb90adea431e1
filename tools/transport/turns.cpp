#include "tools/transport/turns.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <ctime>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <thread>

#include "core/clock.hpp"
#include "tools/transport/order.hpp"

namespace transport {
namespace {

constexpr std::int64_t kQuiet_ns = 20'000'000;  // after this time without a message, none is under way

// The clock id is computed as by pthread_getcpuclockid(), which needs a pthread_t; libraries' threads are known by
// pid_t only.
double ProcessorTime_us(const std::vector<pid_t>& threads) {
  double sum_us = 0.0;
  for (const pid_t thread : threads) {
    timespec used{};
    clock_gettime(static_cast<clockid_t>(~static_cast<unsigned>(thread) << 3 | 6), &used);
    sum_us += 1e6 * static_cast<double>(used.tv_sec) + 1e-3 * static_cast<double>(used.tv_nsec);
  }
  return sum_us;
}

// A thread that receives until the object is destroyed.
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

void SleepUntil(std::int64_t time_ns) {
  const timespec until{time_ns / core::kNanosecondsPerSecond, time_ns % core::kNanosecondsPerSecond};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

std::vector<Hops> TakeTurns(const Channels& channels, std::int64_t rounds, std::int64_t period_ns) {
  std::vector<Hops> hops(channels.size());
  {
    std::vector<std::unique_ptr<Receiver>> receivers;
    for (std::size_t i = 0; i < channels.size(); ++i) {
      receivers.push_back(std::make_unique<Receiver>(channels[i].get(), &hops[i].latency));
    }
    Order order(channels.size());
    const std::int64_t turn_ns = period_ns / static_cast<std::int64_t>(channels.size());
    std::int64_t next_ns = core::MonotonicNow_ns();
    for (std::int64_t round = 0; round < rounds; ++round) {
      for (const std::size_t which : order.Next()) {
        next_ns += turn_ns;
        SleepUntil(next_ns);
        if (channels[which]->Send(core::MonotonicNow_ns())) ++hops[which].sent;
      }
    }
    SleepUntil(core::MonotonicNow_ns() + kQuiet_ns);
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
  std::uint64_t received = receiver.num_received();
  const Load load{static_cast<double>(sent) / took_s, static_cast<double>(received) / took_s};
  // Drains the channel: the next turn would receive the old messages first, and EVENT evicts a reader that does not
  // take them.
  do {
    received = receiver.num_received();
    SleepUntil(core::MonotonicNow_ns() + kQuiet_ns);
  } while (receiver.num_received() != received);
  return load;
}

std::vector<pid_t> Threads() {
  std::vector<pid_t> threads;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) {
    threads.push_back(static_cast<pid_t>(std::stol(entry.path().filename())));
  }
  std::sort(threads.begin(), threads.end());
  return threads;
}

std::vector<double> ProcessorTimePerMessage_us(const std::vector<Worked>& channels, std::int64_t rounds,
                                               bool is_idle_first) {
  if (channels.empty()) return {};
  std::vector<std::unique_ptr<Receiver>> receivers;
  std::vector<std::vector<pid_t>> threads;
  for (const Worked& worked : channels) {
    const std::vector<pid_t> before = Threads();
    receivers.push_back(std::make_unique<Receiver>(worked.channel, nullptr));
    const std::vector<pid_t> after = Threads();
    threads.push_back(worked.threads);
    std::set_difference(after.begin(), after.end(), before.begin(), before.end(), std::back_inserter(threads.back()));
  }
  SleepUntil(core::MonotonicNow_ns() + kQuiet_ns);  // until the receivers have started
  const std::vector<pid_t> sender = {gettid()};
  const std::int64_t turn_ns = core::kTick_ns / static_cast<std::int64_t>(channels.size());
  const auto run = [&](bool sends) {
    std::vector<double> used_us(channels.size());
    for (std::size_t i = 0; i < channels.size(); ++i) used_us[i] = -ProcessorTime_us(threads[i]);
    Order order(channels.size());
    std::int64_t next_ns = core::MonotonicNow_ns();
    for (std::int64_t round = 0; round < rounds; ++round) {
      for (const std::size_t which : order.Next()) {
        next_ns += turn_ns;
        SleepUntil(next_ns);
        if (!sends) continue;
        used_us[which] -= ProcessorTime_us(sender);
        channels[which].channel->Send(core::MonotonicNow_ns());
        used_us[which] += ProcessorTime_us(sender);
      }
    }
    SleepUntil(next_ns + core::kTick_ns);  // until the last messages have arrived
    for (std::size_t i = 0; i < channels.size(); ++i) used_us[i] += ProcessorTime_us(threads[i]);
    return used_us;
  };
  const std::vector<double> first_us = run(!is_idle_first);
  const std::vector<double> second_us = run(is_idle_first);
  std::vector<double> costs_us(channels.size());
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const double more_us = is_idle_first ? second_us[i] - first_us[i] : first_us[i] - second_us[i];
    costs_us[i] = more_us / static_cast<double>(rounds);
  }
  return costs_us;
}

}  // namespace transport
