#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bus/membership/roster.hpp"
#include "tools/oos/doctor/doctor_finding.hpp"
#include "tools/oos/verb/verb.hpp"

namespace oos {

// A network interface as the kernel reports it.
struct Interface {
  std::string name, address;
  unsigned mtu = 0;
  std::uint64_t num_packets = 0;  // received
  std::uint64_t num_lost = 0;     // of these, dropped or damaged
};
Finding JudgeInterface(const Interface& interface);

// Judges the buffer that the kernel grants a UDP socket of the bus, limited by net.core.rmem_max and net.core.wmem_max.
enum class Buffer { kReceive, kSend };
Finding JudgeBuffer(Buffer buffer, int granted_bytes);

// Judges a node of the running session as observed from here: whether it is alive, its clock and its losses.
Finding JudgePeer(const bus::PeerStatus& peer);

// Checks interfaces, buffers, ports, round trip and loss of this machine, and the nodes of the session that runs here
// or that the arguments name.
std::vector<Finding> CheckNetwork(const Arguments& arguments);

}  // namespace oos
