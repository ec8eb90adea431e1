// BULK: a large block from one node to another.
#include <cmath>
#include <cstdio>
#include <functional>
#include <iterator>
#include <thread>
#include <zmq.hpp>

#include "bus/bulk/bulk.hpp"
#include "core/clock.hpp"
#include "tools/bench/one_core.hpp"
#include "tools/transport/bus_channels.hpp"
#include "tools/transport/encryption.hpp"
#include "tools/transport/order.hpp"
#include "tools/transport/studies.hpp"

namespace transport {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{32} << 20;
constexpr std::int64_t kRounds = 12;
constexpr double kMegabytes = 1e-6 * static_cast<double>(kBlockBytes);

double Since_ms(std::int64_t begin_ns) {
  return 1e-6 * static_cast<double>(core::MonotonicNow_ns() - begin_ns);
}

struct Carried {  // NaN: not possible on this machine
  double took_ms = std::nan("");
  std::uint64_t resent_requests = 0;  // chunks that had not arrived 0.3 s after their request
};

// A node that offers blocks, and one that fetches them.
class BulkLink {
 public:
  explicit BulkLink(bool is_encrypted) : link_(Link::Make(is_encrypted)) {
    if (link_ == nullptr) return;
    auto server = bus::BulkServer::Create(link_->near.get(), link_->near_options);
    if (!server || !link_->Start()) return;
    server_ = std::move(*server);
  }
  // The content differs in each round: known content would not be fetched again.
  Carried Fetch(std::uint8_t round) {
    Carried carried;
    if (server_ == nullptr) return carried;
    const auto offer = server_->Offer("block", std::vector<std::uint8_t>(kBlockBytes, round));
    if (!offer) return carried;
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    bus::BulkFetch fetch(*offer, "near", link_->far_options);
    if (fetch.Run(30 * core::kNanosecondsPerSecond)) carried.took_ms = Since_ms(begin_ns);
    carried.resent_requests = fetch.account().dropped[static_cast<std::size_t>(bus::DropReason::kLost)];
    return carried;
  }

 private:
  std::unique_ptr<Link> link_;
  std::unique_ptr<bus::BulkServer> server_;
};

// Sends the block as one message; in the end the receiver has its own copy, as with BULK.
Carried SendByZeroMq(std::uint8_t round) {
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
  Carried carried;
  if (has_come && copy == block) carried.took_ms = Since_ms(begin_ns);
  return carried;
}

}  // namespace

void StudyBulk(const Setting& setting, Report* report) {
  BulkLink sealed(true), plain(false);
  struct Way {
    const char* name;
    std::function<Carried(std::uint8_t)> carry;
    std::uint64_t resent_requests = 0;
  };
  Way ways[] = {{"BULK", [&](std::uint8_t round) { return sealed.Fetch(round); }},
                {"BULK, not encrypted", [&](std::uint8_t round) { return plain.Fetch(round); }},
                {"raw ZeroMQ, tcp", SendByZeroMq}};
  ByRound took_ms;
  Order order(std::size(ways));
  for (std::int64_t round = 0; round < setting.Rounds(kRounds); ++round) {
    for (const std::size_t which : order.Next()) {
      Way& way = ways[which];
      const Carried carried = way.carry(static_cast<std::uint8_t>(round + 1));
      if (round == 0) continue;  // includes the allocation of the memory
      took_ms[way.name].push_back(carried.took_ms);
      way.resent_requests += carried.resent_requests;
    }
  }
  Table table{"bulk", {"way", "bytes", "median_MB_per_s", "worst_MB_per_s", "best_MB_per_s", "chunks_asked_again"}, {}};
  Panel panel{"median of " + std::to_string(kRounds), "", "MB/s", {}, false, false, {}};
  for (const Way& way : ways) {
    const auto speed = [&](double quantile) { return 1e3 * kMegabytes / bench::Quantile(took_ms[way.name], quantile); };
    const double median = speed(0.5);
    table.Add({way.name, std::to_string(kBlockBytes), Cell(median), Cell(speed(1.0)), Cell(speed(0.0)),
               std::to_string(way.resent_requests)});
    panel.bars.push_back({way.name, median, Short(median), "speed"});
    std::printf("%-24s %7.0f MB/s (%.0f to %.0f), %llu chunks requested again\n", way.name, median, speed(1.0),
                speed(0.0), static_cast<unsigned long long>(way.resent_requests));
  }
  report->tables.push_back(table);
  report->charts.emplace_back("bulk",
                              Chart{"A block of 32 MiB on the same machine",
                                    "BULK: chunks by credit, checked by the content's hash; ZeroMQ: one message",
                                    {panel}});
  AddCostOfEncryption("time of a block of 32 MiB", "ms", took_ms, report);
}

}  // namespace transport
