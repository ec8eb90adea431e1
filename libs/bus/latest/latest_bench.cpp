// Round trip of one LATEST hop and back on loopback, against raw UDP datagrams of the same size: what the bus adds.

#include <benchmark/benchmark.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <atomic>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <functional>
#include <numeric>
#include <random>
#include <thread>
#include <vector>
#include <zmq.hpp>

#include "bus/latest/udp_socket.hpp"
#include "bus/membership/registry.hpp"
#include "bus/node.hpp"
#include "bus/rt/latency_stats.hpp"
#include "bus/security/datagram_guard.hpp"
#include "bus/security/keys.hpp"
#include "bus/wire/codec.hpp"
#include "bus/wire/envelope.hpp"
#include "core/clock.hpp"

namespace bus {
namespace {

void Report(benchmark::State& state, const LatencyStats& stats) {
  state.counters["p50_us"] = stats.p50_ns() * 1e-3;
  state.counters["p99_us"] = stats.p99_ns() * 1e-3;
  state.counters["max_us"] = static_cast<double>(stats.max_ns()) * 1e-3;
}

core::ContactSet MakeContacts() {
  core::ContactSet contacts;
  contacts.planes.resize(core::kMaxContactPlanes);
  for (core::ContactPlane& plane : contacts.planes) plane = {123456, {1, 2, 3}, {4, 5, 6}, {0, 0, 1}, 1000};
  return contacts;
}

std::unique_ptr<Node> MakeNode(const std::string& name, const Registry& registry) {
  NodeOptions options;
  options.name = name;
  options.registry = registry.endpoint();
  options.is_encrypted = false;
  return std::move(*Node::Create(options));
}

template <class M>
void BM_LatestRoundTrip(benchmark::State& state, const std::string& there_topic, const std::string& back_topic,
                        M message) {
  const auto registry = std::move(*Registry::Create({.is_encrypted = false}));
  const auto near = MakeNode("near", *registry);
  const auto far = MakeNode("far", *registry);
  auto there = near->WriteLatest<M>(there_topic);
  auto& there_reader = far->ReadLatest<M>(there_topic);
  auto back = far->WriteLatest<M>(back_topic);
  auto& back_reader = near->ReadLatest<M>(back_topic);
  if (!near->Start() || !far->Start()) return state.SkipWithError("start");
  if (!near->WaitForPeers({"far"}, core::kNanosecondsPerSecond) ||
      !far->WaitForPeers({"near"}, core::kNanosecondsPerSecond)) {
    return state.SkipWithError("peers");
  }
  while (!there.has_subscribers()) {
  }
  std::atomic<bool> is_done{false};
  std::thread echo([&] {
    while (!is_done.load(std::memory_order_relaxed)) {
      far->Wait(core::MonotonicNow_ns() + 10'000'000);
      if (!there_reader.is_fresh()) continue;
      M answer = there_reader.value();
      back.Send(answer);
    }
  });
  LatencyStats stats;
  for (auto _ : state) {
    const std::int64_t start = core::MonotonicNow_ns();
    there.Send(message);
    near->Wait(start + 100'000'000);
    if (back_reader.is_fresh()) stats.Add(core::MonotonicNow_ns() - start);
  }
  is_done.store(true);
  echo.join();
  Report(state, stats);
}

void BM_RawUdpRoundTrip(benchmark::State& state) {
  const auto size = static_cast<std::size_t>(state.range(0));
  auto near = std::move(*detail::UdpSocket::Bind("127.0.0.1"));
  auto far = std::move(*detail::UdpSocket::Bind("127.0.0.1"));
  sockaddr_in near_address{}, far_address{};
  detail::ParseEndpoint(near.endpoint(), &near_address);
  detail::ParseEndpoint(far.endpoint(), &far_address);
  std::atomic<bool> is_done{false};
  const auto wait_and_take = [](const detail::UdpSocket& socket, std::uint8_t* bytes) {
    pollfd item{socket.fd(), POLLIN, 0};
    poll(&item, 1, 10);
    return recv(socket.fd(), bytes, kMaxDatagramBytes, MSG_DONTWAIT);
  };
  std::thread echo([&] {
    std::array<std::uint8_t, kMaxDatagramBytes> bytes;
    while (!is_done.load(std::memory_order_relaxed)) {
      const ssize_t got = wait_and_take(far, bytes.data());
      if (got > 0) far.Send(near_address, bytes.data(), static_cast<std::size_t>(got));
    }
  });
  std::array<std::uint8_t, kMaxDatagramBytes> bytes{};
  LatencyStats stats;
  for ([[maybe_unused]] auto _ : state) {
    const std::int64_t start = core::MonotonicNow_ns();
    near.Send(far_address, bytes.data(), size);
    if (wait_and_take(near, bytes.data()) > 0) stats.Add(core::MonotonicNow_ns() - start);
  }
  is_done.store(true);
  echo.join();
  Report(state, stats);
}

template <class M>
void BM_EncodeDecode(benchmark::State& state, M message) {
  LatestCodec<M> codec;
  Envelope envelope, got;
  std::array<std::uint8_t, kMaxDatagramBytes> bytes;
  std::span<const std::uint8_t> payload;
  const std::size_t head = EnvelopeBytes(message.header);
  std::size_t size = 0;
  for (auto _ : state) {
    size = codec.Encode(message, 0, kMaxDatagramBytes - head, bytes.data() + head, kMaxDatagramBytes - head);
    size = WriteEnvelope(envelope, size, bytes.data());
    if (ReadEnvelope({bytes.data(), size}, &got, &payload) != EnvelopeStatus::kOk ||
        !codec.Decode(payload, true, &message)) {
      return state.SkipWithError("decode");
    }
  }
  state.counters["bytes"] = static_cast<double>(size);
}

// The cost of sealing alone: one side seals, the other opens.
void BM_SealOpen(benchmark::State& state) {
  detail::DatagramGuard writer(7, true), reader(7, true);
  const detail::SessionKey key{1, 2, 3};
  writer.SetSessionKey(key, 1);
  reader.SetSessionKey(key, 2);
  detail::KnownSenders senders;
  senders.push_back(reader.Know(5, 1));
  reader.SetSenders(senders);
  reader.TakeSenders();
  Envelope envelope, got;
  envelope.session = 7;
  envelope.node = 5;
  std::array<std::uint8_t, kMaxDatagramBytes> bytes{};
  std::span<const std::uint8_t> payload;
  const std::size_t payload_bytes = static_cast<std::size_t>(state.range(0)) - kEnvelopeFixedBytes;
  for ([[maybe_unused]] auto _ : state) {
    const std::size_t size = writer.SealData(bytes.data(), WriteEnvelopeToSeal(envelope, payload_bytes, bytes.data()));
    if (reader.OpenData({bytes.data(), size}, &got, &payload) != detail::Refusal::kNone) {
      return state.SkipWithError("open");
    }
  }
}

// One hop at 1 kHz, as the nodes run: the receiver sleeps until the datagram comes. Raw UDP, the bus in the clear, the
// bus sealed and ZeroMQ over TCP take turns, so that all see the same machine.
struct Channel {
  std::function<void(std::int64_t now_ns)> send;
  std::function<std::int64_t()> receive;  // waits at most 10 ms; when it was sent, 0: nothing came
  LatencyStats stats;
  std::thread thread;
};

void RunTurns(std::vector<std::unique_ptr<Channel>>* channels, std::int64_t rounds) {
  std::atomic<bool> is_done{false};
  for (auto& channel : *channels) {
    channel->thread = std::thread([raw = channel.get(), &is_done] {
      while (!is_done.load(std::memory_order_relaxed)) {
        const std::int64_t sent_ns = raw->receive();
        if (sent_ns != 0) raw->stats.Add(core::MonotonicNow_ns() - sent_ns);
      }
    });
  }
  const auto turn_ns = core::kTick_ns / static_cast<std::int64_t>(channels->size());
  std::int64_t next_ns = core::MonotonicNow_ns();
  std::vector<std::size_t> order(channels->size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937_64 random(1);
  for (std::int64_t round = 0; round < rounds; ++round) {
    // Random order, so that no contender always follows the same other one.
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
    for (const std::size_t which : order) {
      next_ns += turn_ns;
      const timespec until{next_ns / core::kNanosecondsPerSecond, next_ns % core::kNanosecondsPerSecond};
      clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
      (*channels)[which]->send(core::MonotonicNow_ns());
    }
  }
  is_done.store(true);
  for (auto& channel : *channels) channel->thread.join();
}

struct BusPair {
  std::unique_ptr<Registry> registry;
  std::unique_ptr<Node> near, far;
  LatestWriter<core::DeviceState> writer;
  LatestReader<core::DeviceState>* reader = nullptr;
  core::DeviceState message;

  // False: not connected.
  bool Connect(const std::string& keys, bool keeps_history) {
    const bool is_encrypted = !keys.empty();
    RegistryOptions registry_options;
    registry_options.is_encrypted = is_encrypted;
    registry_options.keys = keys;
    registry = std::move(*Registry::Create(registry_options));
    for (auto* node : {&near, &far}) {
      NodeOptions options;
      options.name = node == &near ? "near" : "far";
      options.registry = registry->endpoint();
      options.is_encrypted = is_encrypted;
      options.keys = keys;
      *node = std::move(*Node::Create(options));
    }
    writer = near->WriteLatest<core::DeviceState>("device/right/state");
    reader = &far->ReadLatest<core::DeviceState>("device/right/state");
    if (keeps_history) reader->KeepHistory(4);
    if (!near->Start() || !far->Start()) return false;
    const std::int64_t end_ns = core::MonotonicNow_ns() + 5 * core::kNanosecondsPerSecond;
    while (!writer.has_subscribers() && core::MonotonicNow_ns() < end_ns) {
    }
    return writer.has_subscribers();
  }
  std::unique_ptr<Channel> MakeChannel() {
    auto channel = std::make_unique<Channel>();
    channel->send = [this](std::int64_t now_ns) {
      message.sample_ns = now_ns;
      writer.Send(message);
    };
    channel->receive = [this] {
      far->Wait(core::MonotonicNow_ns() + 10'000'000);
      return reader->is_fresh() ? reader->value().sample_ns : 0;
    };
    return channel;
  }
};

void BM_HopAt1kHz(benchmark::State& state) {
  const std::string keys =
      (std::filesystem::temp_directory_path() / ("bus_bench-" + std::to_string(getpid()))).string();
  if (!MakeKeys(keys, {"near", "far"})) return state.SkipWithError("keys");
  BusPair clear, sealed, with_history;
  if (!clear.Connect("", false) || !sealed.Connect(keys, false) || !with_history.Connect(keys, true)) {
    return state.SkipWithError("nodes");
  }
  constexpr std::size_t kBytes = 200;
  auto near = std::move(*detail::UdpSocket::Bind("127.0.0.1"));
  auto far = std::move(*detail::UdpSocket::Bind("127.0.0.1"));
  sockaddr_in address{};
  detail::ParseEndpoint(far.endpoint(), &address);
  zmq::context_t context;
  zmq::socket_t push(context, zmq::socket_type::push), pull(context, zmq::socket_type::pull);
  pull.bind("tcp://127.0.0.1:*");
  push.connect(pull.get(zmq::sockopt::last_endpoint));

  const auto raw_channel = [&] {
    auto channel = std::make_unique<Channel>();
    channel->send = [&](std::int64_t now_ns) {
      std::array<std::uint8_t, kBytes> bytes{};
      std::memcpy(bytes.data(), &now_ns, sizeof(now_ns));
      near.Send(address, bytes.data(), bytes.size());
    };
    channel->receive = [&] {
      pollfd item{far.fd(), POLLIN, 0};
      poll(&item, 1, 10);
      std::array<std::uint8_t, kMaxDatagramBytes> bytes;
      std::int64_t sent_ns = 0;
      if (recv(far.fd(), bytes.data(), bytes.size(), MSG_DONTWAIT) > 0) {
        std::memcpy(&sent_ns, bytes.data(), sizeof(sent_ns));
      }
      return sent_ns;
    };
    return channel;
  };
  const auto zmq_channel = [&] {
    auto channel = std::make_unique<Channel>();
    channel->send = [&](std::int64_t now_ns) {
      zmq::message_t bytes(kBytes);
      std::memcpy(bytes.data(), &now_ns, sizeof(now_ns));
      push.send(bytes, zmq::send_flags::dontwait);
    };
    channel->receive = [&] {
      pull.set(zmq::sockopt::rcvtimeo, 10);
      zmq::message_t bytes;
      std::int64_t sent_ns = 0;
      if (pull.recv(bytes)) std::memcpy(&sent_ns, bytes.data(), sizeof(sent_ns));
      return sent_ns;
    };
    return channel;
  };
  std::vector<std::unique_ptr<Channel>> channels;
  channels.push_back(raw_channel());
  channels.push_back(clear.MakeChannel());
  channels.push_back(sealed.MakeChannel());
  channels.push_back(with_history.MakeChannel());
  channels.push_back(zmq_channel());
  for ([[maybe_unused]] auto _ : state) RunTurns(&channels, 3'000);
  const std::array<const char*, 5> names = {"raw", "clear", "sealed", "history", "zmq"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    state.counters[std::string(names[i]) + "_p50_us"] = channels[i]->stats.p50_ns() * 1e-3;
    state.counters[std::string(names[i]) + "_p99_us"] = channels[i]->stats.p99_ns() * 1e-3;
    state.counters[std::string(names[i]) + "_over_raw"] = channels[i]->stats.p50_ns() / channels[0]->stats.p50_ns();
  }
  std::filesystem::remove_all(keys);
}

BENCHMARK_CAPTURE(BM_EncodeDecode, proxy, core::HapticProxy{});
BENCHMARK_CAPTURE(BM_EncodeDecode, contacts_20_planes, MakeContacts());
BENCHMARK_CAPTURE(BM_EncodeDecode, device, core::DeviceState{});
BENCHMARK(BM_SealOpen)->Arg(200)->Arg(400)->Arg(1100);
BENCHMARK(BM_HopAt1kHz)->Iterations(1)->UseRealTime();
BENCHMARK(BM_RawUdpRoundTrip)->Arg(400)->Arg(1100)->UseRealTime();
BENCHMARK_CAPTURE(BM_LatestRoundTrip, proxy, "haptic/a/proxy", "haptic/b/proxy", core::HapticProxy{})->UseRealTime();
BENCHMARK_CAPTURE(BM_LatestRoundTrip, contacts_20_planes, "contacts/a", "contacts/b", MakeContacts())->UseRealTime();

}  // namespace
}  // namespace bus
