// How much goes through, and what a message costs the processor.
#include <cstdio>
#include <functional>

#include "tools/transport/bus_channels.hpp"
#include "tools/transport/raw_channels.hpp"
#include "tools/transport/studies.hpp"
#include "tools/transport/turns.hpp"

namespace transport {

void StudyLoad(const Setting& setting, Report* report) {
  std::vector<std::function<std::unique_ptr<Channel>()>> makers = {
      [] { return MakeUdp(kSmallBytes); },
      [] { return MakeLatest(kSmallBytes, true); },
      [] { return MakeLatest(kSmallBytes, false); },
      [] { return MakeState(true); },
      [] { return MakeEvent(true); },
      [] { return MakeEvent(false); },
      [] { return MakeZeroMq("raw ZeroMQ, tcp", "tcp://127.0.0.1:*", kSmallBytes); },
      [] { return MakeZeroMq("raw ZeroMQ, ipc", "ipc://*", kSmallBytes); },
  };
  for (const Peer& peer : setting.peers) makers.emplace_back([&peer] { return peer.make(kSmallBytes); });

  Table table{"load", {"transport", "sent_per_s", "seen_per_s", "processor_us_per_message"}, {}};
  Panel rate{"messages a second that the reader saw", "", "1000/s", {}, false, false, {}};
  Panel cost{"processor time of a message, all threads", "", "us", {}, false, false, {}};
  double latest_us = 0.0, plain_us = 0.0;
  for (const auto& make : makers) {
    const auto channel = make();
    if (channel == nullptr) continue;
    const double cost_us = ProcessorTimePerMessage_us(channel.get(), setting.Rounds(200));
    const Load load = Flood(channel.get(), 0.5 * setting.effort);
    const std::string& name = channel->name();
    if (name == "LATEST") latest_us = cost_us;
    if (name == "LATEST, not encrypted") plain_us = cost_us;
    table.Add({name, Cell(load.sent_per_s), Cell(load.received_per_s), Cell(cost_us)});
    std::printf("%-24s %8.0f /s sent, %8.0f /s seen, %6.1f us of processor time a message\n", name.c_str(),
                load.sent_per_s, load.received_per_s, cost_us);
    rate.bars.push_back({name, load.received_per_s * 1e-3, Short(load.received_per_s * 1e-3), "rate"});
    cost.bars.push_back({name, cost_us, Short(cost_us), "cost"});
  }
  report->tables.push_back(table);
  report->charts.emplace_back(
      "load", Chart{"What goes through and what it costs, about 200 B",
                    "left: one sender without a pause, one receiver; right: at 1 kHz, sender and receiver together, "
                    "without what the idle threads take",
                    {rate, cost}});
  std::printf("encryption of a LATEST message costs %.1f us of processor time, both ends\n", latest_us - plain_us);
}

}  // namespace transport
