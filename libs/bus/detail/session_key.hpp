#pragma once

#include <cstdint>
#include <string>

namespace bus::detail {

// 32 bytes that UDP datagrams of a session are encrypted with: HMAC-SHA-256(registry's secret key, "VR-OOS session" |
// u64 session, little endian). A registry that dies and comes back hands out the same. `secret_key`: Z85.
std::string DeriveSessionKey(const std::string& secret_key, std::uint64_t session);

}  // namespace bus::detail
