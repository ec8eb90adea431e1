// Latency of STATE, EVENT and SERVICE, which pass through the bus thread and are delivered when the reader's step
// thread calls Wait.
#include <atomic>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <thread>

#include "core/clock.hpp"
#include "tools/transport/bus_channels.hpp"
#include "tools/transport/encryption.hpp"
#include "tools/transport/order.hpp"
#include "tools/transport/raw_channels.hpp"
#include "tools/transport/studies.hpp"
#include "tools/transport/turns.hpp"

namespace transport {
namespace {

// Round trip: from setting a parameter to the owner's acknowledgement.
class Service {
 public:
  explicit Service(bool is_encrypted)
      : name_(is_encrypted ? "SERVICE, there and back" : "SERVICE, there and back, not encrypted"),
        link_(Link::Make(is_encrypted)) {
    if (link_ == nullptr) return;
    link_->far->OwnParameters({"bench"});
    if (!link_->Start()) link_.reset();
  }
  [[nodiscard]] const std::string& name() const { return name_; }
  // Empty if this machine cannot run it.
  bus::LatencyStats Call(std::int64_t rounds) const {
    bus::LatencyStats latency;
    if (link_ == nullptr) return latency;
    std::atomic<bool> is_done{false};
    std::thread owner([&] {
      core::ParameterChange change;
      std::uint64_t ticket = 0;
      while (!is_done.load(std::memory_order_relaxed)) {
        link_->far->Wait(core::MonotonicNow_ns() + kPollPeriod_ns);
        while (link_->far->PollParameter(&change, &ticket)) link_->far->AckParameter(ticket, 1, true);
      }
    });
    core::ParameterChange change;
    change.name = "bench";
    for (std::int64_t round = 0; round < rounds; ++round) {
      const std::int64_t begin_ns = core::MonotonicNow_ns();
      if (link_->near->SetParameter("far", change)) latency.Add(core::MonotonicNow_ns() - begin_ns);
    }
    is_done.store(true);
    owner.join();
    return latency;
  }

 private:
  std::string name_;
  std::unique_ptr<Link> link_;
};

constexpr int kTurns = 8;
constexpr std::int64_t kRounds = 250, kCalls = 125;  // in a turn

}  // namespace

void StudyClasses(const Setting& setting, Report* report) {
  Table table{"classes", {"class", "received", "p50_us", "p90_us", "p99_us", "max_us"}, {}};
  Panel median{"median", "", "us", {}, false, false, {}};
  Panel tail{"99th percentile", "", "us", {}, false, false, {}};
  const auto add = [&](const std::string& name, const bus::LatencyStats& latency) {
    if (latency.count() == 0) {
      report->skipped.push_back("classes, " + name + ": not on this machine");
      return;
    }
    table.Add({name, std::to_string(latency.count()), Cell(latency.p50_ns() * 1e-3), Cell(latency.p90_ns() * 1e-3),
               Cell(latency.p99_ns() * 1e-3), Cell(static_cast<double>(latency.max_ns()) * 1e-3)});
    std::printf("%-36s p50 %7.1f us, p99 %7.1f us\n", name.c_str(), latency.p50_ns() * 1e-3, latency.p99_ns() * 1e-3);
    median.bars.push_back({name, latency.p50_ns() * 1e-3, Short(latency.p50_ns() * 1e-3), "bus"});
    tail.bars.push_back({name, latency.p99_ns() * 1e-3, Short(latency.p99_ns() * 1e-3), "bus"});
  };
  Channels channels;
  const auto take = [&channels](std::unique_ptr<Channel> channel) {
    if (channel != nullptr) channels.push_back(std::move(channel));
  };
  take(MakeZeroMq("raw ZeroMQ, tcp", "tcp://127.0.0.1:*", kSmallBytes));
  for (const bool is_encrypted : {true, false}) {
    take(MakeLatest(kSmallBytes, is_encrypted));
    take(MakeState(is_encrypted));
    take(MakeEvent(is_encrypted));
  }
  const Service services[] = {Service(true), Service(false)};
  // One at a time in short turns: readers that poll every 50 us would compete for the processor.
  std::vector<bus::LatencyStats> latencies(channels.size() + std::size(services));
  const auto name_of = [&](std::size_t which) {
    return which < channels.size() ? channels[which]->name() : services[which - channels.size()].name();
  };
  const auto measure = [&](std::size_t which) {
    if (which >= channels.size()) return services[which - channels.size()].Call(setting.Rounds(kCalls));
    Channels one;
    one.push_back(std::move(channels[which]));
    const bus::LatencyStats latency = TakeTurns(one, setting.Rounds(kRounds), core::kTick_ns)[0].latency;
    channels[which] = std::move(one[0]);
    return latency;
  };
  ByRound medians_us;
  Order order(latencies.size());
  for (int turn = 0; turn < kTurns; ++turn) {
    for (const std::size_t which : order.Next()) {
      const bus::LatencyStats latency = measure(which);
      latencies[which].Merge(latency);
      medians_us[name_of(which)].push_back(latency.count() > 0 ? latency.p50_ns() * 1e-3 : std::nan(""));
    }
  }
  for (std::size_t i = 0; i < latencies.size(); ++i) add(name_of(i), latencies[i]);
  report->tables.push_back(table);
  report->charts.emplace_back("classes",
                              Chart{"Classes of topics on the same machine, about 200 B",
                                    "1 kHz, in turns; the reader of STATE, EVENT and SERVICE polls every 50 us",
                                    {median, tail}});
  AddCostOfEncryption("latency of about 200 B", "us", medians_us, report);
}

}  // namespace transport
