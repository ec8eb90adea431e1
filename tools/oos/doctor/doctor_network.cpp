#include "tools/oos/doctor/doctor_network.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "bus/latest/udp_socket.hpp"
#include "bus/wire/envelope.hpp"
#include "core/clock.hpp"
#include "tools/oos/attach/attach.hpp"

namespace oos {
namespace {

constexpr unsigned kUdpHeadBytes = 28;  // IPv4 and UDP
constexpr unsigned kNeededMtu = static_cast<unsigned>(bus::kMaxDatagramBytes) + kUdpHeadBytes;
constexpr double kMuchLoss = 1e-3;
constexpr std::int64_t kWideBound_ns = 1'000'000;
constexpr std::int64_t kObservation_ns = 2'000'000'000;
constexpr int kRoundTrips = 500;

std::string Percent(std::uint64_t part, std::uint64_t all) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f %%",
                all == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(all));
  return text;
}

std::string Ms(std::int64_t ns) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f ms", static_cast<double>(ns) * 1e-6);
  return text;
}

bool IsMuch(std::uint64_t lost, std::uint64_t all) {
  return static_cast<double>(lost) > kMuchLoss * static_cast<double>(all);
}

std::uint64_t NumberIn(const std::string& file) {
  std::uint64_t number = 0;
  std::ifstream(file) >> number;
  return number;
}

std::vector<Interface> Interfaces() {
  std::vector<Interface> all;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return all;
  for (const ifaddrs* item = list; item != nullptr; item = item->ifa_next) {
    const bool is_up = (item->ifa_flags & IFF_UP) != 0;
    if (!is_up || item->ifa_addr == nullptr || item->ifa_addr->sa_family != AF_INET) continue;
    Interface interface;
    interface.name = item->ifa_name;
    char text[INET_ADDRSTRLEN] = "";
    inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(item->ifa_addr)->sin_addr, text, sizeof text);
    interface.address = text;
    const std::string folder = "/sys/class/net/" + interface.name + "/";
    interface.mtu = static_cast<unsigned>(NumberIn(folder + "mtu"));
    interface.num_packets = NumberIn(folder + "statistics/rx_packets");
    interface.num_lost = NumberIn(folder + "statistics/rx_dropped") + NumberIn(folder + "statistics/rx_errors");
    all.push_back(interface);
  }
  freeifaddrs(list);
  return all;
}

// The buffer size that the kernel grants the bus's sockets, which request more.
int GrantedBytes(const bus::detail::UdpSocket& socket, int option) {
  int granted = 0;
  socklen_t size = sizeof granted;
  getsockopt(socket.fd(), SOL_SOCKET, option, &granted, &size);
  return granted / 2;  // the kernel doubles what it grants, for its own needs (man 7 socket)
}

std::vector<Finding> CheckBuffers() {
  const auto socket = bus::detail::UdpSocket::Bind("127.0.0.1");
  if (!socket) return {};  // CheckRoundTrip says why
  return {JudgeBuffer(Buffer::kReceive, GrantedBytes(*socket, SO_RCVBUF)),
          JudgeBuffer(Buffer::kSend, GrantedBytes(*socket, SO_SNDBUF))};
}

Finding CheckPorts() {
  unsigned first = 0, last = 0;
  std::ifstream("/proc/sys/net/ipv4/ip_local_port_range") >> first >> last;
  constexpr unsigned kNeeded = 1000;  // five nodes, a port per socket and per connection, and those that just closed
  const std::string range = std::to_string(first) + " to " + std::to_string(last);
  if (last >= first + kNeeded)
    return {"ports", Grade::kOk, "ports " + range + " for nodes; a firewall must let them through", ""};
  return {"ports", Grade::kWarn, "only ports " + range + " for nodes",
          "sysctl -w net.ipv4.ip_local_port_range='32768 60999'"};
}

// Round trip of the largest datagrams between two sockets of this process: the lower bound of any hop on this machine.
Finding CheckRoundTrip() {
  auto here = bus::detail::UdpSocket::Bind("127.0.0.1"), there = bus::detail::UdpSocket::Bind("127.0.0.1");
  sockaddr_in to_here{}, to_there{};
  if (!here || !there || !bus::detail::ParseEndpoint(here->endpoint(), &to_here) ||
      !bus::detail::ParseEndpoint(there->endpoint(), &to_there)) {
    return {"loopback", Grade::kFail, "no UDP port on 127.0.0.1: " + std::string(std::strerror(errno)),
            "bring the loopback interface up: ip link set lo up"};
  }
  std::array<std::uint8_t, bus::kMaxDatagramBytes> bytes{};
  const auto hop = [&bytes](const bus::detail::UdpSocket& from, const sockaddr_in& to,
                            const bus::detail::UdpSocket& by) {
    pollfd item{by.fd(), POLLIN, 0};
    return from.Send(to, bytes.data(), bytes.size()) && poll(&item, 1, 100) == 1 &&
           recv(by.fd(), bytes.data(), bytes.size(), MSG_DONTWAIT) == static_cast<ssize_t>(bytes.size());
  };
  std::vector<std::int64_t> times_ns;
  for (int i = 0; i < kRoundTrips; ++i) {
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    if (hop(*here, to_there, *there) && hop(*there, to_here, *here)) {
      times_ns.push_back(core::MonotonicNow_ns() - begin_ns);
    }
  }
  const auto num_lost = static_cast<std::uint64_t>(kRoundTrips) - times_ns.size();
  if (num_lost > 0) {
    return {"loopback", Grade::kFail, Percent(num_lost, kRoundTrips) + " of the datagrams on 127.0.0.1 are lost",
            "look for packet filters: nft list ruleset"};
  }
  std::sort(times_ns.begin(), times_ns.end());
  const std::int64_t p99_ns = times_ns[times_ns.size() * 99 / 100];
  const std::string what =
      "round trip on 127.0.0.1: median " + Ms(times_ns[times_ns.size() / 2]) + ", p99 " + Ms(p99_ns) + ", none lost";
  if (p99_ns < kWideBound_ns) return {"loopback", Grade::kOk, what, ""};
  return {"loopback", Grade::kWarn, what + ": other processes keep this machine busy", "end them, see 'top'"};
}

std::vector<Finding> CheckSession(const Arguments& arguments) {
  auto node = Attach(arguments, "doctor");
  if (!node) {
    if (!arguments.has("--registry")) {
      return {
          {"session", Grade::kOk, "no session runs here; clocks and losses of nodes are checked while one does", ""}};
    }
    return {{"session", Grade::kFail, node.error().detail, "name the session that runs, and its key directory"}};
  }
  if (const auto started = (*node)->Start(kObservation_ns); !started) {
    return {{"session", Grade::kFail, started.error().detail,
             "start it with 'oos run' or 'oos launch', or let TCP through to it"}};
  }
  const std::int64_t end_ns =
      core::MonotonicNow_ns() + kObservation_ns;  // long enough for some heartbeats of every node
  while (core::MonotonicNow_ns() < end_ns) (*node)->Wait(end_ns);
  std::vector<Finding> findings;
  for (const bus::PeerStatus& peer : (*node)->Peers()) {
    if (!peer.is_observer) findings.push_back(JudgePeer(peer));
  }
  return findings;
}

}  // namespace

Finding JudgeInterface(const Interface& interface) {
  std::string what = "interface " + interface.name + " " + interface.address + ", MTU " + std::to_string(interface.mtu);
  if (interface.mtu < kNeededMtu) {
    return {"interface", Grade::kFail,
            what + ": datagrams of " + std::to_string(bus::kMaxDatagramBytes) + " B do not fit in one piece",
            "ip link set " + interface.name + " mtu 1500, or at least " + std::to_string(kNeededMtu)};
  }
  what += ", " + Percent(interface.num_lost, interface.num_packets) + " of " + std::to_string(interface.num_packets) +
          " packets lost";
  if (!IsMuch(interface.num_lost, interface.num_packets)) return {"interface", Grade::kOk, what, ""};
  return {"interface", Grade::kWarn, what,
          "see which with 'ip -s -s link show " + interface.name + "': change the cable, or ethtool -G " +
              interface.name + " rx 4096"};
}

Finding JudgeBuffer(Buffer buffer, int granted_bytes) {
  const bool is_receive = buffer == Buffer::kReceive;
  const std::string what = std::string("UDP buffers of ") + std::to_string(granted_bytes >> 10) + " kB for " +
                           (is_receive ? "receiving" : "sending");
  if (granted_bytes >= bus::detail::kUdpBufferBytes) return {"buffers", Grade::kOk, what, ""};
  return {"buffers", Grade::kWarn,
          what + " only: a node that " + (is_receive ? "is delayed" : "sends a burst") + " loses messages",
          std::string("add 'net.core.") + (is_receive ? "rmem_max" : "wmem_max") + " = " +
              std::to_string(bus::detail::kUdpBufferBytes) +
              "' to /etc/sysctl.d/50-realtime.conf, then sysctl --system"};
}

Finding JudgePeer(const bus::PeerStatus& peer) {
  std::uint64_t sent = 0, lost = 0;
  for (const bus::ReportedAccount& account : peer.accounts) {
    const bus::TopicRule* rule = bus::FindTopicRule(account.topic);
    if (account.is_writer || rule == nullptr || rule->topic_class != bus::TopicClass::kLatest) continue;
    sent += account.sent;
    lost += account.dropped;
  }
  if (!peer.is_alive) {
    return {"node", Grade::kFail, peer.name + ": silent for " + Ms(peer.age_ns),
            "see its log in the run's folder; if it runs, let UDP through to " + peer.udp_endpoint + " and back"};
  }
  const std::string what = peer.name + " at " + peer.udp_endpoint + ": " + Percent(lost, sent) + " of " +
                           std::to_string(sent) + " LATEST messages lost on the way to it, ";
  if (peer.clock_bound_ns == INT64_MAX) {
    return {"node", Grade::kWarn, what + "its clock is not known",
            "let UDP through from " + peer.udp_endpoint + " to this machine and back"};
  }
  // Half of the shortest round trip is part of the bound (bus/membership/clock_estimate.hpp).
  const std::string clock = peer.clock_bound_ns == 0 ? "the same clock"
                                                     : "clock known within " + Ms(peer.clock_bound_ns) +
                                                           ", round trip at most " + Ms(2 * peer.clock_bound_ns);
  if (peer.is_stalled) {
    return {"node", Grade::kWarn, what + clock + "; its step thread stands still", "see its log in the run's folder"};
  }
  if (IsMuch(lost, sent)) {
    return {"node", Grade::kWarn, what + clock, "use a wired network of its own, or cores of its own for the node"};
  }
  if (peer.clock_bound_ns > kWideBound_ns) {
    return {"node", Grade::kWarn, what + clock, "use a wired network: times across machines are no better than that"};
  }
  return {"node", Grade::kOk, what + clock, ""};
}

std::vector<Finding> CheckNetwork(const Arguments& arguments) {
  std::vector<Finding> findings;
  for (const Interface& interface : Interfaces()) findings.push_back(JudgeInterface(interface));
  if (findings.empty()) {
    findings.push_back({"interface", Grade::kFail, "no interface with an IPv4 address is up", "ip link set lo up"});
  }
  findings.push_back(CheckRoundTrip());
  for (Finding& finding : CheckBuffers()) findings.push_back(std::move(finding));
  findings.push_back(CheckPorts());
  for (Finding& finding : CheckSession(arguments)) findings.push_back(std::move(finding));
  return findings;
}

}  // namespace oos
