#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace scene {

// Where datagrams are received.
struct UdpAddress {
  std::uint32_t ip = 0;  // of this machine, or of a multicast group; 0: any of this machine
  std::uint16_t port = 0;
};

// "PORT", "ADDRESS:PORT" or "GROUP:PORT", the address as four numbers.
std::optional<UdpAddress> ParseUdpAddress(std::string_view text);

}  // namespace scene
