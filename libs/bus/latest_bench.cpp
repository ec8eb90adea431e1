// Round trip of one LATEST hop and back on loopback, against raw UDP datagrams of the same size: what the bus adds.

#include <benchmark/benchmark.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <atomic>
#include <thread>

#include "bus/codec.hpp"
#include "bus/detail/udp_socket.hpp"
#include "bus/envelope.hpp"
#include "bus/node.hpp"
#include "bus/registry.hpp"
#include "bus/rt/latency_stats.hpp"
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

BENCHMARK_CAPTURE(BM_EncodeDecode, proxy, core::HapticProxy{});
BENCHMARK_CAPTURE(BM_EncodeDecode, contacts_20_planes, MakeContacts());
BENCHMARK(BM_RawUdpRoundTrip)->Arg(400)->Arg(1100)->UseRealTime();
BENCHMARK_CAPTURE(BM_LatestRoundTrip, proxy, "haptic/a/proxy", "haptic/b/proxy", core::HapticProxy{})->UseRealTime();
BENCHMARK_CAPTURE(BM_LatestRoundTrip, contacts_20_planes, "contacts/a", "contacts/b", MakeContacts())->UseRealTime();

}  // namespace
}  // namespace bus
