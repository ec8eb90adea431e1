// BULK: a large block from one node to another.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <thread>
#include <zmq.hpp>

#include "bus/bulk.hpp"
#include "core/clock.hpp"
#include "tools/bench/one_core.hpp"
#include "tools/transport/bus_channels.hpp"
#include "tools/transport/studies.hpp"

namespace transport {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{32} << 20;

double MegabytesPerSecond(std::int64_t begin_ns) {
  return 1e3 * static_cast<double>(kBlockBytes) / static_cast<double>(core::MonotonicNow_ns() - begin_ns);
}

// A node that offers blocks, and one that fetches them.
class BulkLink {
 public:
  explicit BulkLink(bool is_encrypted) : link_(Link::Make(is_encrypted)) {
    if (link_ == nullptr) return;
    auto server = bus::BulkServer::Create(link_->near.get(), link_->near_options);
    if (!server || !link_->Start()) return;
    server_ = std::move(*server);
  }
  // NaN: not on this machine. Another content each time, or it need not be fetched.
  double Fetch(std::uint8_t round) {
    if (server_ == nullptr) return std::nan("");
    const auto offer = server_->Offer("block", std::vector<std::uint8_t>(kBlockBytes, round));
    if (!offer) return std::nan("");
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    bus::BulkFetch fetch(*offer, "near", link_->far_options);
    return fetch.Run(30 * core::kNanosecondsPerSecond) ? MegabytesPerSecond(begin_ns) : std::nan("");
  }

 private:
  std::unique_ptr<Link> link_;
  std::unique_ptr<bus::BulkServer> server_;
};

// The same as one message; the receiver has its own copy in the end, as with BULK.
double SendByZeroMq(std::uint8_t round) {
  zmq::context_t context;
  zmq::socket_t push(context, zmq::socket_type::push), pull(context, zmq::socket_type::pull);
  pull.bind("tcp://127.0.0.1:*");
  push.connect(pull.get(zmq::sockopt::last_endpoint));
  const std::vector<std::uint8_t> block(kBlockBytes, round);
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  std::thread sender([&] { push.send(zmq::buffer(block)); });
  zmq::message_t message;
  const bool has_come = pull.recv(message).has_value();
  const std::vector<std::uint8_t> copy(message.data<std::uint8_t>(), message.data<std::uint8_t>() + message.size());
  sender.join();
  return has_come && copy == block ? MegabytesPerSecond(begin_ns) : std::nan("");
}

}  // namespace

void StudyBulk(const Setting& setting, Report* report) {
  BulkLink sealed(true), plain(false);
  struct Way {
    const char* name;
    std::vector<double> speeds;
  };
  Way ways[] = {{"BULK", {}}, {"BULK, not encrypted", {}}, {"raw ZeroMQ, tcp", {}}};
  for (std::int64_t round = 0; round < setting.Rounds(6); ++round) {
    const auto content = static_cast<std::uint8_t>(round + 1);
    ways[0].speeds.push_back(sealed.Fetch(content));
    ways[1].speeds.push_back(plain.Fetch(content));
    ways[2].speeds.push_back(SendByZeroMq(content));
  }
  Table table{"bulk", {"way", "bytes", "median_MB_per_s", "worst_MB_per_s"}, {}};
  Panel panel{"median of seven", "", "MB/s", {}, false, false, {}};
  for (const Way& way : ways) {
    const double median = bench::Quantile(way.speeds, 0.5);
    table.Add({way.name, std::to_string(kBlockBytes), Cell(median), Cell(bench::Quantile(way.speeds, 0.0))});
    panel.bars.push_back({way.name, median, Short(median), "speed"});
    std::printf("%-24s %7.0f MB/s\n", way.name, median);
  }
  report->tables.push_back(table);
  report->charts.emplace_back("bulk",
                              Chart{"A block of 32 MiB on the same machine",
                                    "BULK: chunks by credit, checked by the content's hash; ZeroMQ: one message",
                                    {panel}});
}

}  // namespace transport
