#include "scene/udp_address.hpp"

#include <arpa/inet.h>

#include <charconv>
#include <string>

namespace scene {

std::optional<UdpAddress> ParseUdpAddress(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  UdpAddress result;
  if (colon != std::string_view::npos) {
    in_addr ip{};
    if (inet_pton(AF_INET, std::string(text.substr(0, colon)).c_str(), &ip) != 1) return std::nullopt;
    result.ip = ntohl(ip.s_addr);
    text.remove_prefix(colon + 1);
  }
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), result.port);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return result;
}

}  // namespace scene
