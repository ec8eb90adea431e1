// Age of the newest sample that a reader has while packets are lost between two machines. LATEST, encrypted and not,
// and ZeroMQ over TCP carry the same samples at the same time through the same lossy filter.
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <thread>
#include <zmq.hpp>

#include "bus/membership/registry.hpp"
#include "bus/node.hpp"
#include "bus/security/keys.hpp"
#include "core/clock.hpp"
#include "core/messages/device.hpp"
#include "tools/bench/one_core.hpp"
#include "tools/transport/bus_channels.hpp"
#include "tools/transport/lossy_network.hpp"
#include "tools/transport/order.hpp"
#include "tools/transport/studies.hpp"
#include "tools/transport/turns.hpp"

namespace transport {
namespace {

constexpr std::int64_t kStart_ns = 10 * core::kNanosecondsPerSecond;
constexpr int kPerMille[] = {0, 1, 10, 50};
// The reader's period is a thousandth longer than the writer's, so that its ticks sweep over all phases of the writer's
// once a second.
constexpr std::int64_t kReaderPeriod_ns = core::kTick_ns + core::kTick_ns / 1000;
constexpr std::int64_t kRunIn = 50;  // samples sent before the reader's first tick

// A transport that carries the samples across the network. One thread sends, another one reads.
class Contender {
 public:
  explicit Contender(std::string name) : name_(std::move(name)) {}
  virtual ~Contender() = default;
  Contender(const Contender&) = delete;
  Contender& operator=(const Contender&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  virtual void Send() = 0;
  // When the newest sample received so far was published [ns]; 0 if none was received.
  virtual std::int64_t NewestPublished_ns() = 0;

 private:
  std::string name_;
};

using Contenders = std::vector<std::unique_ptr<Contender>>;

class LatestContender final : public Contender {
 public:
  explicit LatestContender(bool is_encrypted)
      : Contender(is_encrypted ? "LATEST" : "LATEST, not encrypted"), is_encrypted_(is_encrypted) {}

  // False if something cannot be set up.
  bool SetUp(const LossyNetwork& network) {
    link_.is_encrypted = is_encrypted_;
    if (is_encrypted_) {
      link_.keys = std::filesystem::temp_directory_path() / ("oos_bench_age-" + std::to_string(getpid()));
      if (!bus::MakeKeys(link_.keys, {"near", "far"})) return false;
    }
    bool is_ready = false;
    network.DoNear([&] {
      bus::RegistryOptions options;
      options.endpoint = std::string("tcp://") + LossyNetwork::kNearAddress + ":0";
      options.is_encrypted = is_encrypted_;
      options.keys = link_.keys.string();
      auto registry = bus::Registry::Create(options);
      if (!registry) return;
      link_.registry = std::move(*registry);
      is_ready = MakeNode("near", LossyNetwork::kNearAddress, &link_.near);
    });
    if (!is_ready) return false;
    network.DoFar([&] { is_ready = MakeNode("far", LossyNetwork::kFarAddress, &link_.far); });
    if (!is_ready) return false;
    writer_ = link_.near->WriteLatest<core::DeviceState>(bus::DeviceStateTopic("bench"));
    reader_ = &link_.far->ReadLatest<core::DeviceState>(bus::DeviceStateTopic("bench"));
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
    return true;
  }
  void Send() override { writer_.Send(state_); }
  std::int64_t NewestPublished_ns() override {
    link_.far->Poll();
    return reader_->has_value() ? reader_->value().header.publish_ns : 0;
  }

 private:
  bool MakeNode(const std::string& name, const std::string& address, std::unique_ptr<bus::Node>* node) const {
    bus::NodeOptions options;
    options.name = name;
    options.registry = link_.registry->endpoint();
    options.bind_address = address;
    options.is_encrypted = is_encrypted_;
    options.keys = link_.keys.string();
    auto made = bus::Node::Create(options);
    if (made) *node = std::move(*made);
    return made.has_value();
  }

  bool is_encrypted_;
  Link link_;
  core::DeviceState state_;
  bus::LatestWriter<core::DeviceState> writer_;
  bus::LatestReader<core::DeviceState>* reader_ = nullptr;
};

class TcpContender final : public Contender {
 public:
  TcpContender() : Contender("raw ZeroMQ, tcp") {}

  bool SetUp(const LossyNetwork& network) {
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
  void Send() override {
    zmq::message_t message(kSmallBytes);
    const std::int64_t now_ns = core::MonotonicNow_ns();
    std::memcpy(message.data(), &now_ns, sizeof(now_ns));
    push_.send(message, zmq::send_flags::dontwait);
  }
  std::int64_t NewestPublished_ns() override {
    zmq::message_t message;
    while (pull_.recv(message, zmq::recv_flags::dontwait)) std::memcpy(&newest_ns_, message.data(), sizeof(newest_ns_));
    return newest_ns_;
  }

 private:
  zmq::context_t near_context_, far_context_;
  zmq::socket_t push_, pull_;
  std::int64_t newest_ns_ = 0;
};

// Empty if something cannot be set up.
Contenders MakeContenders(const LossyNetwork& network) {
  auto sealed = std::make_unique<LatestContender>(true), plain = std::make_unique<LatestContender>(false);
  auto tcp = std::make_unique<TcpContender>();
  Contenders contenders;
  if (!sealed->SetUp(network) || !plain->SetUp(network) || !tcp->SetUp(network)) return contenders;
  contenders.push_back(std::move(sealed));
  contenders.push_back(std::move(plain));
  contenders.push_back(std::move(tcp));
  return contenders;
}

struct AgeSamples {
  std::vector<std::vector<double>> ages_ms;            // by contender
  std::vector<double> writer_late_ms, reader_late_ms;  // wake-up delay of the two threads
};

// A thread in one network sends a sample each ms; a thread in the other reads at ticks of its own. The age is the time
// of the reading minus the publish time of the newest sample, by the clock that both share. It includes the hop and
// every delay of either thread.
AgeSamples MeasureAges(const LossyNetwork& network, const Contenders& contenders, std::int64_t num_samples) {
  AgeSamples samples;
  samples.ages_ms.resize(contenders.size());
  const auto wake_up = [](std::int64_t due_ns, std::vector<double>* late_ms) {
    SleepUntil(due_ns);
    late_ms->push_back(1e-6 * static_cast<double>(core::MonotonicNow_ns() - due_ns));
  };
  std::atomic<bool> is_done{false};
  const std::int64_t start_ns = core::MonotonicNow_ns() + 10 * core::kTick_ns;
  std::thread writer([&] {
    network.DoNear([&] {
      Order order(contenders.size());
      for (std::int64_t tick = 0; !is_done.load(std::memory_order_relaxed); ++tick) {
        wake_up(start_ns + tick * core::kTick_ns, &samples.writer_late_ms);
        for (const std::size_t which : order.Next()) contenders[which]->Send();
      }
    });
  });
  network.DoFar([&] {
    Order order(contenders.size());
    for (std::int64_t sample = 0; sample < num_samples; ++sample) {
      wake_up(start_ns + kRunIn * core::kTick_ns + sample * kReaderPeriod_ns, &samples.reader_late_ms);
      for (const std::size_t which : order.Next()) {
        const std::int64_t published_ns = contenders[which]->NewestPublished_ns();
        const std::int64_t now_ns = core::MonotonicNow_ns();
        if (published_ns != 0) samples.ages_ms[which].push_back(1e-6 * static_cast<double>(now_ns - published_ns));
      }
    }
  });
  is_done.store(true);
  writer.join();
  return samples;
}

}  // namespace

void StudyAge(const Setting& setting, Report* report) {
  const auto network = LossyNetwork::Make();
  const Contenders contenders = network ? MakeContenders(**network) : Contenders();
  if (contenders.empty()) {
    report->skipped.push_back("age: " + (network ? std::string("the nodes do not meet") : network.error().detail));
    return;
  }
  Table table{"age",
              {"transport", "loss_percent", "looks", "p50_ms", "p99_ms", "p999_ms", "max_ms", "writer_late_p99_ms",
               "reader_late_p99_ms"},
              {}};
  Panel tail{"99th percentile", "packets lost [%]", "ms", {}, false, true, {}};
  Panel worst{"worst", "packets lost [%]", "ms", {}, false, true, {}};
  for (const auto& contender : contenders) {
    tail.series.push_back({contender->name(), {}, true});
    worst.series.push_back({contender->name(), {}, true});
  }
  std::vector<double> p99_at_1_ms(contenders.size());
  for (const int per_mille : kPerMille) {
    (*network)->Lose(per_mille);
    const AgeSamples samples = MeasureAges(**network, contenders, setting.Rounds(8'000));
    const double loss_percent = 0.1 * per_mille;
    const double writer_late_ms = bench::Quantile(samples.writer_late_ms, 0.99);
    const double reader_late_ms = bench::Quantile(samples.reader_late_ms, 0.99);
    for (std::size_t i = 0; i < contenders.size(); ++i) {
      const std::vector<double>& of = samples.ages_ms[i];
      const double p99_ms = bench::Quantile(of, 0.99);
      const double max_ms = bench::Quantile(of, 1.0);
      table.Add({contenders[i]->name(), Cell(loss_percent), std::to_string(of.size()), Cell(bench::Quantile(of, 0.5)),
                 Cell(p99_ms), Cell(bench::Quantile(of, 0.999)), Cell(max_ms), Cell(writer_late_ms),
                 Cell(reader_late_ms)});
      std::printf("%-22s %4.1f %% lost: p50 %8.3f ms, p99 %8.3f ms, p99.9 %8.3f ms, worst %8.3f ms\n",
                  contenders[i]->name().c_str(), loss_percent, bench::Quantile(of, 0.5), p99_ms,
                  bench::Quantile(of, 0.999), max_ms);
      tail.series[i].points.push_back({loss_percent, p99_ms, ""});
      worst.series[i].points.push_back({loss_percent, max_ms, ""});
      if (per_mille == 10) p99_at_1_ms[i] = p99_ms;
    }
    std::printf("the writer woke up %.3f ms late in one of 100 ticks (worst %.3f ms), the reader %.3f ms (%.3f ms)\n",
                writer_late_ms, bench::Quantile(samples.writer_late_ms, 1.0), reader_late_ms,
                bench::Quantile(samples.reader_late_ms, 1.0));
  }
  report->tables.push_back(table);
  report->charts.emplace_back("age", Chart{"Age of the newest sample while packets are lost",
                                           "a sample each ms from a thread in one network namespace to one in another, "
                                           "whose tick sweeps over the writer's; all carry the same samples at once",
                                           {tail, worst}});
  std::string beside;
  for (std::size_t i = 1; i < contenders.size(); ++i) {
    beside += (i > 1 ? "; " : "") + contenders[i]->name() + ": " + Short(p99_at_1_ms[i]) + " ms";
  }
  report->AddGoal("age of the newest LATEST sample, 1 % of packets lost, 1 kHz: 99th percentile", "at most 2.1 ms",
                  Short(p99_at_1_ms[0]) + " ms (" + beside + ")", p99_at_1_ms[0] <= 2.1);
}

}  // namespace transport
