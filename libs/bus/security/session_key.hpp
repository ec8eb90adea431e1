#pragma once

#include <cstdint>
#include <string>

namespace bus::detail {

// The 32-byte key of a session's UDP datagrams: HMAC-SHA-256(registry's secret key, "VR-OOS session" | u64 session,
// little endian), so a restarted registry derives the same one. `secret_key`: Z85.
std::string DeriveSessionKey(const std::string& secret_key, std::uint64_t session);

}  // namespace bus::detail
