// Throughput, and processor time of a message.
#include <algorithm>
#include <cstdio>
#include <iterator>

#include "core/clock.hpp"
#include "tools/bench/one_core.hpp"
#include "tools/transport/bus_channels.hpp"
#include "tools/transport/encryption.hpp"
#include "tools/transport/order.hpp"
#include "tools/transport/raw_channels.hpp"
#include "tools/transport/scatter.hpp"
#include "tools/transport/studies.hpp"
#include "tools/transport/turns.hpp"

namespace transport {
namespace {

constexpr int kCostTurns = 24;
constexpr std::int64_t kCostRounds = 150;  // three periods of the heartbeats, which go on meanwhile
constexpr int kFloodTurns = 6;
constexpr double kFlood_s = 0.1;  // shorter than the silence after which starved nodes declare each other dead

struct Contender {
  std::unique_ptr<Channel> channel;
  std::vector<pid_t> threads;  // that the channel started
};

// Groups of channels that are measured together, in turns message by message. A reader that polls every 50 us is
// measured alone.
std::vector<std::vector<Worked>> GroupsOf(const std::vector<Contender>& contenders) {
  std::vector<std::vector<Worked>> groups(1);
  for (const Contender& contender : contenders) {
    const std::string& name = contender.channel->name();
    const Worked worked{contender.channel.get(), contender.threads};
    if (name.starts_with("STATE") || name.starts_with("EVENT")) {
      groups.push_back({worked});
    } else {
      groups.front().push_back(worked);
    }
  }
  return groups;
}

std::vector<Contender> MakeAll(const Setting& setting) {
  std::vector<ChannelMaker> makers = {
      MakeUdp,
      [](std::size_t num_bytes) { return MakeLatest(num_bytes, true); },
      [](std::size_t num_bytes) { return MakeLatest(num_bytes, false); },
      [](std::size_t) { return MakeState(true); },
      [](std::size_t) { return MakeEvent(true); },
      [](std::size_t) { return MakeEvent(false); },
      [](std::size_t num_bytes) { return MakeZeroMq("raw ZeroMQ, tcp", "tcp://127.0.0.1:*", num_bytes); },
      [](std::size_t num_bytes) { return MakeZeroMq("raw ZeroMQ, ipc", "ipc://*", num_bytes); },
  };
  for (const Peer& peer : setting.peers) makers.push_back(peer.make);
  std::vector<Contender> contenders;
  for (const ChannelMaker& make : makers) {
    const std::vector<pid_t> before = Threads();
    Contender contender{make(kSmallBytes), {}};
    const std::vector<pid_t> after = Threads();
    std::set_difference(after.begin(), after.end(), before.begin(), before.end(),
                        std::back_inserter(contender.threads));
    if (contender.channel != nullptr) contenders.push_back(std::move(contender));
  }
  return contenders;
}

}  // namespace

void StudyLoad(const Setting& setting, Report* report) {
  const std::vector<Contender> contenders = MakeAll(setting);
  ByRound costs_us, sent_per_s, seen_per_s;
  const std::vector<std::vector<Worked>> groups = GroupsOf(contenders);
  Order order_of_groups(groups.size()), order(contenders.size());
  for (int turn = 0; turn < kCostTurns; ++turn) {
    for (const std::size_t which : order_of_groups.Next()) {
      const std::vector<Worked>& group = groups[which];
      const std::vector<double> some_us = ProcessorTimePerMessage_us(group, setting.Rounds(kCostRounds), turn % 2 == 0);
      for (std::size_t i = 0; i < group.size(); ++i) costs_us[group[i].channel->name()].push_back(some_us[i]);
    }
  }
  for (int turn = 0; turn < kFloodTurns; ++turn) {
    for (const std::size_t which : order.Next()) {
      Channel* const channel = contenders[which].channel.get();
      const Load load = Flood(channel, kFlood_s * setting.effort);
      sent_per_s[channel->name()].push_back(load.sent_per_s);
      seen_per_s[channel->name()].push_back(load.received_per_s);
    }
  }

  Table table{
      "load",
      {"transport", "sent_per_s", "seen_per_s", "processor_us_per_message", "processor_us_low", "processor_us_high"},
      {}};
  Panel rate{"messages a second that the reader saw", "", "1000/s", {}, false, false, {}};
  Panel cost{"processor time of a message, all its threads", "", "us", {}, false, false, {}};
  for (const Contender& contender : contenders) {
    const std::string& name = contender.channel->name();
    const double sent = bench::Quantile(sent_per_s[name], 0.5);
    const double seen = bench::Quantile(seen_per_s[name], 0.5);
    const Scatter cost_us = ScatterOf(costs_us[name]);
    table.Add({name, Cell(sent), Cell(seen), Cell(cost_us.median), Cell(cost_us.low), Cell(cost_us.high)});
    std::printf("%-24s %8.0f /s sent, %8.0f /s seen, %6.1f us of processor time a message (%.1f to %.1f)\n",
                name.c_str(), sent, seen, cost_us.median, cost_us.low, cost_us.high);
    rate.bars.push_back({name, seen * 1e-3, Short(seen * 1e-3), "rate"});
    cost.bars.push_back({name, cost_us.median, Short(cost_us.median), "cost"});
  }
  report->tables.push_back(table);
  report->charts.emplace_back(
      "load", Chart{"What goes through and what it costs, about 200 B",
                    "left: one sender without a pause, one receiver; right: at 1 kHz, sender and receiver together, "
                    "without what the idle threads take; medians, all in turns",
                    {rate, cost}});
  AddCostOfEncryption("processor time of a message, both ends", "us", costs_us, report);
}

}  // namespace transport
