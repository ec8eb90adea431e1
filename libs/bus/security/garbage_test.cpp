// Garbage at every port that a live run has open, with and without keys: counted, refused, and nobody is disturbed.

#include <dirent.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "bus/bulk/bulk.hpp"
#include "bus/security/keys.hpp"
#include "bus/testing/make_node.hpp"
#include "bus/wire/control.hpp"
#include "proto/bus.pb.h"

namespace bus {
namespace {

using testing::ExpectAccountsClose;
using testing::kLong_ns;
using testing::Until;
using testing::WaitBriefly;

struct Port {
  sockaddr_in address{};
  bool is_datagram = false;
};

// All sockets of this process that accept input from outside; found by the system, so that none is forgotten.
std::vector<Port> OpenPorts() {
  std::vector<Port> ports;
  DIR* const folder = opendir("/proc/self/fd");
  while (const dirent* entry = readdir(folder)) {
    const int fd = std::atoi(entry->d_name);
    Port port;
    int type = 0, listens = 0;
    socklen_t size = sizeof(type);
    if (getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size) != 0) continue;
    size = sizeof(listens);
    getsockopt(fd, SOL_SOCKET, SO_ACCEPTCONN, &listens, &size);
    size = sizeof(port.address);
    if (getsockname(fd, reinterpret_cast<sockaddr*>(&port.address), &size) != 0) continue;
    if (port.address.sin_family != AF_INET || port.address.sin_port == 0) continue;
    port.is_datagram = type == SOCK_DGRAM;
    if (port.is_datagram || listens != 0) ports.push_back(port);
  }
  closedir(folder);
  return ports;
}

std::string RandomBytes(std::mt19937_64* random, std::size_t size) {
  std::string bytes(size, '\0');
  for (char& byte : bytes) byte = static_cast<char>((*random)());
  return bytes;
}

// One of each kind of malformed input.
std::vector<std::string> Garbage(std::mt19937_64* random) {
  const detail::Identity stranger{7, 99, 1};
  oos::Control control;
  control.mutable_heartbeat()->set_name("stranger");
  const auto bytes = detail::EncodeControl(stranger, TopicClass::kControl, control);
  const std::string sound(bytes.begin(), bytes.end());
  std::string flipped = sound;
  flipped[20] = static_cast<char>(flipped[20] ^ 1);
  std::vector<std::string> all = {"x",         sound,  sound.substr(0, 50), sound.substr(0, sound.size() - 1),
                                  sound + "x", flipped};
  for (const std::size_t size : {3, 64, 96, 1200, 1500, 60000}) all.push_back(RandomBytes(random, size));
  std::string zmtp = "\xff" + std::string(8, '\0') + "\x7f\x03";
  all.push_back(zmtp);
  all.push_back(zmtp + RandomBytes(random, 200));
  all.push_back(std::string("GET / HTTP/1.1\r\n\r\n"));
  return all;
}

void SendTo(const Port& port, const std::string& bytes) {
  const int fd = socket(AF_INET, port.is_datagram ? SOCK_DGRAM : SOCK_STREAM, 0);
  const auto* address = reinterpret_cast<const sockaddr*>(&port.address);
  if (connect(fd, address, sizeof(port.address)) == 0) {
    [[maybe_unused]] const ssize_t sent = send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  close(fd);
}

struct LiveRun {
  explicit LiveRun(bool is_encrypted) {
    std::string keys;
    if (is_encrypted) {
      folder = std::filesystem::path(::testing::TempDir()) / ("garbage-" + std::to_string(getpid()));
      EXPECT_TRUE(MakeKeys(folder, {"physics_node", "visual_node"}).has_value());
      keys = folder.string();
    }
    RegistryOptions options;
    options.session = 7;
    options.is_encrypted = is_encrypted;
    options.keys = keys;
    registry = std::move(*Registry::Create(options));
    for (auto* node : {&writer, &reader}) {
      NodeOptions of_node;
      of_node.name = node == &writer ? "physics_node" : "visual_node";
      of_node.registry = registry->endpoint();
      of_node.session = 7;
      of_node.is_encrypted = is_encrypted;
      of_node.keys = keys;
      *node = std::move(*Node::Create(of_node));
      (node == &writer ? writer_options : reader_options) = of_node;
    }
    bulk = std::move(*BulkServer::Create(writer.get(), writer_options));
    latest = writer->WriteLatest<core::PhysicsState>(kPhysicsStateTopic);
    latest_reader = &reader->ReadLatest<core::PhysicsState>(kPhysicsStateTopic);
    reader->ReadEvents();
    EXPECT_TRUE(writer->Start().has_value());
    EXPECT_TRUE(reader->Start().has_value());
    EXPECT_TRUE(Until([this] {
      WaitBriefly(*reader);
      return latest.has_subscribers() && reader->IsAlive("physics_node") && writer->IsAlive("visual_node");
    }));
  }
  ~LiveRun() {
    bulk.reset();
    reader.reset();
    writer.reset();
    registry.reset();
    if (!folder.empty()) std::filesystem::remove_all(folder);
  }

  // Every class still gets through, and no node was declared dead.
  void ExpectGoesOn(std::uint64_t round) {
    core::PhysicsState state;
    state.tick = round;
    latest.Send(state);
    EXPECT_TRUE(Until([&] {
      WaitBriefly(*reader);
      return latest_reader->has_value() && latest_reader->value().tick == round;
    }));
    core::Event event;
    event.name = "round";
    event.detail = std::to_string(round);
    EXPECT_TRUE(writer->Emit(event));
    bool has_come = false, was_lost = false;
    EXPECT_TRUE(Until([&] {
      WaitBriefly(*reader);
      WaitBriefly(*writer);
      core::Event got;
      while (reader->PollEvent(&got)) {
        has_come |= got.name == "round" && got.detail == event.detail;
        was_lost |= got.name == "node_lost";
      }
      return has_come;
    }));
    EXPECT_FALSE(was_lost);
    const auto offer = bulk->Offer("block", {1, 2, static_cast<std::uint8_t>(round)});
    ASSERT_TRUE(offer.has_value()) << offer.error().detail;
    const auto fetched = BulkFetch(*offer, "physics_node", reader_options).Run(kLong_ns);
    EXPECT_TRUE(fetched.has_value()) << fetched.error().detail;
  }
  std::uint64_t refused_datagrams() const {
    std::uint64_t count = 0;
    for (const auto* node : {&writer, &reader}) {
      for (const RefusalCount& refusal : (*node)->counters().refusals) {
        const bool is_of_zmq =
            refusal.reason == "connection" || refusal.reason == "message" || refusal.reason == "bulk";
        count += is_of_zmq ? 0 : refusal.count;
      }
    }
    return count;
  }

  std::filesystem::path folder;
  std::unique_ptr<Registry> registry;
  std::unique_ptr<Node> writer, reader;
  NodeOptions writer_options, reader_options;
  std::unique_ptr<BulkServer> bulk;
  LatestWriter<core::PhysicsState> latest;
  LatestReader<core::PhysicsState>* latest_reader = nullptr;
};

class GarbageAtEveryPort : public ::testing::TestWithParam<bool> {};

TEST_P(GarbageAtEveryPort, IsCountedAndRefused) {
  LiveRun run(GetParam());
  run.ExpectGoesOn(1);
  const std::uint64_t before = run.refused_datagrams();
  const std::vector<Port> ports = OpenPorts();
  std::size_t num_datagram_ports = 0;
  for (const Port& port : ports) num_datagram_ports += port.is_datagram ? 1 : 0;
  ASSERT_GE(num_datagram_ports, 4u);                 // data and heartbeats of two nodes
  ASSERT_GE(ports.size() - num_datagram_ports, 4u);  // both nodes, the registry, and BULK

  std::mt19937_64 random(1);
  std::uint64_t num_datagrams = 0;
  for (std::uint64_t round = 2; round < 12; ++round) {
    for (const std::string& bytes : Garbage(&random)) {
      for (const Port& port : ports) {
        SendTo(port, bytes);
        num_datagrams += port.is_datagram ? 1 : 0;
        run.writer->Poll();  // so that no socket's buffer runs over
        run.reader->Poll();
      }
    }
    run.ExpectGoesOn(round);
  }
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*run.writer);
    WaitBriefly(*run.reader);
    return run.refused_datagrams() == before + num_datagrams;
  })) << run.refused_datagrams() - before
      << " of " << num_datagrams;
  EXPECT_GT(run.registry->num_refused(), 0u);
  EXPECT_GT(run.bulk->num_refused(), 0u);
  ExpectAccountsClose({run.writer.get(), run.reader.get()});
  EXPECT_EQ(run.registry->Names().size(), 2u);
}

INSTANTIATE_TEST_SUITE_P(Keys, GarbageAtEveryPort, ::testing::Bool(),
                         [](const auto& with) { return with.param ? "Encrypted" : "InTheClear"; });

}  // namespace
}  // namespace bus
