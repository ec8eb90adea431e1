#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace device {

// SHA-1 [FIPS 180-4], which the opening of a WebSocket needs. Not for anything that must be secret.
std::array<std::uint8_t, 20> Sha1(std::string_view text);

// Base64 [RFC 4648].
std::string Base64(const std::uint8_t* bytes, std::size_t size);

}  // namespace device
