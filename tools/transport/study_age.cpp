// How old the newest sample is that a reader sees when packets are lost between two machines: LATEST beside ZeroMQ over
// TCP, which carry the same samples at the same time through the same filter.
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <zmq.hpp>

#include "bus/keys.hpp"
#include "bus/node.hpp"
#include "bus/registry.hpp"
#include "core/clock.hpp"
#include "tools/bench/one_core.hpp"
#include "tools/transport/bus_channels.hpp"
#include "tools/transport/lossy_network.hpp"
#include "tools/transport/studies.hpp"

namespace transport {
namespace {

constexpr std::int64_t kStart_ns = 10 * core::kNanosecondsPerSecond;
constexpr int kPerMille[] = {0, 1, 10, 50};

void SleepUntil(std::int64_t time_ns) {
  const timespec until{time_ns / core::kNanosecondsPerSecond, time_ns % core::kNanosecondsPerSecond};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

// Both contenders across the network. The nodes are encrypted, as in a run.
class Contest {
 public:
  // False: something cannot be set up.
  bool SetUp(const LossyNetwork& network) {
    link_.keys = std::filesystem::temp_directory_path() / ("oos_bench_age-" + std::to_string(getpid()));
    if (!bus::MakeKeys(link_.keys, {"near", "far"})) return false;
    bool is_ready = false;
    network.DoNear([&] {
      bus::RegistryOptions options;
      options.endpoint = std::string("tcp://") + LossyNetwork::kNearAddress + ":0";
      options.keys = link_.keys.string();
      auto registry = bus::Registry::Create(options);
      if (!registry) return;
      link_.registry = std::move(*registry);
      is_ready = MakeNode("near", LossyNetwork::kNearAddress, &link_.near);
    });
    if (!is_ready) return false;
    network.DoFar([&] { is_ready = MakeNode("far", LossyNetwork::kFarAddress, &link_.far); });
    if (!is_ready) return false;
    writer_ = link_.near->WriteLatest<core::HapticProxy>(bus::HapticProxyTopic("right"));
    reader_ = &link_.far->ReadLatest<core::HapticProxy>(bus::HapticProxyTopic("right"));
    network.DoNear([&] { is_ready = link_.near->Start(kStart_ns).has_value(); });
    if (!is_ready) return false;
    network.DoFar([&] { is_ready = link_.far->Start(kStart_ns).has_value(); });
    if (!is_ready || !link_.near->WaitForPeers({"far"}, kStart_ns) || !link_.far->WaitForPeers({"near"}, kStart_ns)) {
      return false;
    }
    for (const std::int64_t end_ns = core::MonotonicNow_ns() + kStart_ns; !writer_.has_subscribers();) {
      link_.near->Wait(core::MonotonicNow_ns() + core::kTick_ns);
      if (core::MonotonicNow_ns() > end_ns) return false;
    }
    try {
      network.DoFar([&] {
        pull_ = zmq::socket_t(far_context_, zmq::socket_type::pull);
        pull_.bind(std::string("tcp://") + LossyNetwork::kFarAddress + ":*");
      });
      const std::string endpoint = pull_.get(zmq::sockopt::last_endpoint);
      network.DoNear([&] {
        push_ = zmq::socket_t(near_context_, zmq::socket_type::push);
        push_.set(zmq::sockopt::linger, 0);
        push_.connect(endpoint);
      });
    } catch (const zmq::error_t&) {
      return false;
    }
    return true;
  }

  void Send(std::uint64_t cycle) {
    core::HapticProxy proxy;
    proxy.cycle = cycle;
    writer_.Send(proxy);
    zmq::message_t message(kSmallBytes);
    std::memcpy(message.data(), &cycle, sizeof(cycle));
    push_.send(message, zmq::send_flags::dontwait);
  }
  // Newest cycle that each has; 0: none.
  std::uint64_t LookAtLatest() {
    link_.far->Poll();
    return reader_->has_value() ? reader_->value().cycle : 0;
  }
  std::uint64_t LookAtTcp() {
    zmq::message_t message;
    while (pull_.recv(message, zmq::recv_flags::dontwait))
      std::memcpy(&newest_tcp_, message.data(), sizeof(newest_tcp_));
    return newest_tcp_;
  }

 private:
  bool MakeNode(const std::string& name, const std::string& address, std::unique_ptr<bus::Node>* node) {
    bus::NodeOptions options;
    options.name = name;
    options.registry = link_.registry->endpoint();
    options.bind_address = address;
    options.keys = link_.keys.string();
    auto made = bus::Node::Create(options);
    if (made) *node = std::move(*made);
    return made.has_value();
  }

  Link link_;
  bus::LatestWriter<core::HapticProxy> writer_;
  bus::LatestReader<core::HapticProxy>* reader_ = nullptr;
  zmq::context_t near_context_, far_context_;
  zmq::socket_t push_, pull_;
  std::uint64_t newest_tcp_ = 0;
};

struct Ages {
  std::vector<double> latest_ms, tcp_ms;
};

// A sample each ms; the reader looks at a phase of the writer's tick that sweeps over the whole of it. An age counts
// from when the sample was due, so this computer's own delays in sending are left out; those in looking are in it.
Ages Watch(Contest* contest, std::int64_t rounds, std::uint64_t* cycle) {
  Ages ages;
  const std::uint64_t first = *cycle + 1;
  const std::int64_t start_ns = core::MonotonicNow_ns() + core::kTick_ns;
  for (std::int64_t round = 0; round < rounds; ++round) {
    const std::int64_t due_ns = start_ns + round * core::kTick_ns;
    SleepUntil(due_ns);
    contest->Send(++*cycle);
    const std::int64_t phase_ns = (50 + 7 * round % 901) * core::kTick_ns / 1000;
    SleepUntil(due_ns + phase_ns);
    const auto age_ms = [&](std::uint64_t seen) {
      return static_cast<double>(*cycle - seen) + 1e-6 * static_cast<double>(phase_ns);
    };
    const std::uint64_t latest = contest->LookAtLatest();
    if (latest >= first) ages.latest_ms.push_back(age_ms(latest));
    const std::uint64_t tcp = contest->LookAtTcp();
    if (tcp >= first) ages.tcp_ms.push_back(age_ms(tcp));
  }
  return ages;
}

}  // namespace

void StudyAge(const Setting& setting, Report* report) {
  const auto network = LossyNetwork::Make();
  Contest contest;
  if (!network || !contest.SetUp(**network)) {
    report->skipped.push_back("age: " + (network ? std::string("the nodes do not meet") : network.error().detail));
    return;
  }
  Table table{"age", {"transport", "loss_percent", "looks", "p50_ms", "p99_ms", "p999_ms", "max_ms"}, {}};
  Panel tail{"99th percentile", "packets lost [%]", "ms", {}, false, true, {}};
  Panel worst{"worst", "packets lost [%]", "ms", {}, false, true, {}};
  Series tails[] = {{"LATEST", {}, true}, {"raw ZeroMQ, tcp", {}, true}};
  Series worsts[] = {{"LATEST", {}, true}, {"raw ZeroMQ, tcp", {}, true}};
  std::uint64_t cycle = 0;
  double p99_at_1_ms = 0.0, tcp_at_1_ms = 0.0;
  for (const int per_mille : kPerMille) {
    (*network)->Lose(per_mille);
    const Ages ages = Watch(&contest, setting.Rounds(8'000), &cycle);
    for (int i = 0; i < 2; ++i) {
      const std::vector<double>& of = i == 0 ? ages.latest_ms : ages.tcp_ms;
      const double loss_percent = 0.1 * per_mille;
      const double p99_ms = bench::Quantile(of, 0.99);
      const double max_ms = bench::Quantile(of, 1.0);
      table.Add({tails[i].name, Cell(loss_percent), std::to_string(of.size()), Cell(bench::Quantile(of, 0.5)),
                 Cell(p99_ms), Cell(bench::Quantile(of, 0.999)), Cell(max_ms)});
      std::printf("%-18s %4.1f %% lost: p50 %8.2f ms, p99 %8.2f ms, worst %8.2f ms\n", tails[i].name.c_str(),
                  loss_percent, bench::Quantile(of, 0.5), p99_ms, max_ms);
      tails[i].points.push_back({loss_percent, p99_ms, ""});
      worsts[i].points.push_back({loss_percent, max_ms, ""});
      if (per_mille == 10) (i == 0 ? p99_at_1_ms : tcp_at_1_ms) = p99_ms;
    }
  }
  tail.series.assign(std::begin(tails), std::end(tails));
  worst.series.assign(std::begin(worsts), std::end(worsts));
  report->tables.push_back(table);
  report->charts.emplace_back("age", Chart{"Age of the newest sample while packets are lost",
                                           "a sample each ms between two network namespaces; the phase of the reader's "
                                           "tick sweeps; both carry the same samples at the same time",
                                           {tail, worst}});
  report->AddGoal("age of the newest LATEST sample, 1 % of packets lost, 1 kHz: 99th percentile", "at most 2.1 ms",
                  Short(p99_at_1_ms) + " ms (ZeroMQ over TCP beside it: " + Short(tcp_at_1_ms) + " ms)",
                  p99_at_1_ms <= 2.1);
}

}  // namespace transport
