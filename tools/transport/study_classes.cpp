// STATE, EVENT and SERVICE, which go through the bus thread and are seen when the reader's step thread looks.
#include <atomic>
#include <cstdio>
#include <thread>

#include "core/clock.hpp"
#include "tools/transport/bus_channels.hpp"
#include "tools/transport/raw_channels.hpp"
#include "tools/transport/studies.hpp"
#include "tools/transport/turns.hpp"

namespace transport {
namespace {

// There and back: a parameter is set and the owner's acknowledgement has come.
bus::LatencyStats CallService(bool is_encrypted, std::int64_t rounds) {
  bus::LatencyStats latency;
  const auto link = Link::Make(is_encrypted);
  if (link == nullptr) return latency;
  link->far->OwnParameters({"bench"});
  if (!link->Start()) return latency;
  std::atomic<bool> is_done{false};
  std::thread owner([&] {
    core::ParameterChange change;
    std::uint64_t ticket = 0;
    while (!is_done.load(std::memory_order_relaxed)) {
      link->far->Wait(core::MonotonicNow_ns() + kLook_ns);
      while (link->far->PollParameter(&change, &ticket)) link->far->AckParameter(ticket, 1, true);
    }
  });
  core::ParameterChange change;
  change.name = "bench";
  for (std::int64_t round = 0; round < rounds; ++round) {
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    if (link->near->SetParameter("far", change)) latency.Add(core::MonotonicNow_ns() - begin_ns);
  }
  is_done.store(true);
  owner.join();
  return latency;
}

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
  // One after the other in short turns: readers that look every 50 us would keep each other from the processor.
  constexpr int kTurns = 8;
  std::vector<bus::LatencyStats> latencies(channels.size());
  for (int turn = 0; turn < kTurns; ++turn) {
    for (std::size_t i = 0; i < channels.size(); ++i) {
      Channels one;
      one.push_back(std::move(channels[i]));
      latencies[i].Merge(TakeTurns(one, setting.Rounds(250), core::kTick_ns)[0].latency);
      channels[i] = std::move(one[0]);
    }
  }
  for (std::size_t i = 0; i < channels.size(); ++i) add(channels[i]->name(), latencies[i]);
  channels.clear();
  for (const bool is_encrypted : {true, false}) {
    add(is_encrypted ? "SERVICE, there and back" : "SERVICE, there and back, not encrypted",
        CallService(is_encrypted, setting.Rounds(1'000)));
  }
  report->tables.push_back(table);
  report->charts.emplace_back("classes",
                              Chart{"Classes of topics on the same machine, about 200 B",
                                    "1 kHz, in turns; the reader of STATE, EVENT and SERVICE looks every 50 us",
                                    {median, tail}});
}

}  // namespace transport
