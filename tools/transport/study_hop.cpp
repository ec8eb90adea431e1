// Latency of one hop at 1 kHz by transport and size. All take turns; each receiver sleeps until a message arrives.
#include <cmath>
#include <cstdio>
#include <map>

#include "core/clock.hpp"
#include "tools/transport/bus_channels.hpp"
#include "tools/transport/encryption.hpp"
#include "tools/transport/raw_channels.hpp"
#include "tools/transport/studies.hpp"
#include "tools/transport/turns.hpp"

namespace transport {
namespace {

constexpr int kTurns = 10;
constexpr std::int64_t kRounds = 500;
constexpr std::size_t kSizes[] = {kSmallBytes, kLargeBytes, kSheetBytes};

void Add(std::unique_ptr<Channel> channel, const std::string& name, Channels* channels, Report* report) {
  if (channel != nullptr) {
    channels->push_back(std::move(channel));
  } else {
    report->skipped.push_back("hop, " + name + ": not on this machine");
  }
}

Channels MakeAll(std::size_t num_bytes, const Setting& setting, Report* report) {
  Channels channels;
  Add(MakeSharedMemory(num_bytes), "shared memory", &channels, report);
  Add(MakeUdp(num_bytes), "raw UDP", &channels, report);
  Add(MakeLatest(num_bytes, true), "LATEST", &channels, report);
  Add(MakeLatest(num_bytes, false), "LATEST, not encrypted", &channels, report);
  Add(MakeZeroMq("raw ZeroMQ, tcp", "tcp://127.0.0.1:*", num_bytes), "raw ZeroMQ, tcp", &channels, report);
  Add(MakeZeroMq("raw ZeroMQ, ipc", "ipc://*", num_bytes), "raw ZeroMQ, ipc", &channels, report);
  for (const Peer& peer : setting.peers) Add(peer.make(num_bytes), peer.name, &channels, report);
  return channels;
}

void AddGoals(const std::map<std::string, double>& p50_us, Report* report) {
  const auto of = [&p50_us](const std::string& name) {
    const auto found = p50_us.find(name);
    return found == p50_us.end() ? 0.0 : found->second;
  };
  const double udp_us = of("raw UDP");
  const double tcp_us = of("raw ZeroMQ, tcp");
  if (udp_us == 0.0 || tcp_us == 0.0) return;
  for (const std::string name : {"LATEST", "LATEST, not encrypted"}) {
    const std::string what = name + " hop, 215 B at 1 kHz: median against ";
    report->AddGoal(what + "raw UDP", "at most 1.5", Short(of(name) / udp_us), of(name) <= 1.5 * udp_us);
    report->AddGoal(what + "raw ZeroMQ over TCP", "at most 0.5", Short(of(name) / tcp_us), of(name) <= 0.5 * tcp_us);
  }
}

}  // namespace

void StudyHop(const Setting& setting, Report* report) {
  Table table{"hop",
              {"transport", "bytes", "sent", "received", "p50_us", "p90_us", "p99_us", "max_us", "p50_over_raw_udp"},
              {}};
  std::map<std::string, Series> medians, tails;
  for (const std::size_t num_bytes : kSizes) {
    const Channels channels = MakeAll(num_bytes, setting, report);
    std::vector<Hops> hops(channels.size());
    ByRound medians_us;
    for (int turn = 0; turn < kTurns; ++turn) {
      const std::vector<Hops> some = TakeTurns(channels, setting.Rounds(kRounds), core::kTick_ns);
      for (std::size_t i = 0; i < channels.size(); ++i) {
        hops[i].sent += some[i].sent;
        hops[i].latency.Merge(some[i].latency);
        const bool has_come = some[i].latency.count() > 0;
        medians_us[channels[i]->name()].push_back(has_come ? some[i].latency.p50_ns() * 1e-3 : std::nan(""));
      }
    }
    std::map<std::string, double> p50_us;
    for (std::size_t i = 0; i < channels.size(); ++i) {
      p50_us[channels[i]->name()] = hops[i].latency.p50_ns() * 1e-3;
    }
    for (std::size_t i = 0; i < channels.size(); ++i) {
      const std::string& name = channels[i]->name();
      const bus::LatencyStats& latency = hops[i].latency;
      if (latency.count() == 0) {
        report->skipped.push_back("hop, " + name + " with " + std::to_string(num_bytes) + " B: nothing arrived");
        continue;
      }
      const double ratio = p50_us[name] / p50_us["raw UDP"];
      table.Add({name, std::to_string(num_bytes), std::to_string(hops[i].sent), std::to_string(latency.count()),
                 Cell(p50_us[name]), Cell(latency.p90_ns() * 1e-3), Cell(latency.p99_ns() * 1e-3),
                 Cell(static_cast<double>(latency.max_ns()) * 1e-3), Cell(ratio)});
      std::printf("%-24s %6zu B: p50 %7.1f us, p99 %7.1f us, %.2f of raw UDP\n", name.c_str(), num_bytes, p50_us[name],
                  latency.p99_ns() * 1e-3, ratio);
      const auto x = static_cast<double>(num_bytes);
      medians[name].points.push_back({x, p50_us[name], ""});
      tails[name].points.push_back({x, latency.p99_ns() * 1e-3, ""});
    }
    if (num_bytes == kSmallBytes) AddGoals(p50_us, report);
    AddCostOfEncryption("hop of " + std::to_string(num_bytes) + " B", "us", medians_us, report);
  }
  Panel median{"median", "bytes", "us", {}, true, true, {}};
  Panel tail{"99th percentile", "bytes", "us", {}, true, true, {}};
  for (auto& [name, series] : medians) {
    series.name = tails[name].name = name;
    median.series.push_back(series);
    tail.series.push_back(tails[name]);
  }
  report->tables.push_back(table);
  report->charts.emplace_back(
      "hop", Chart{"One hop on the same machine, 1 kHz",
                   "the receiver sleeps until something comes; all take turns in one run; shared memory is the floor",
                   {median, tail}});
}

}  // namespace transport
