#include "bus/security/session_key.hpp"

#include <sodium.h>
#include <zmq.h>

#include <array>

namespace bus::detail {

std::string DeriveSessionKey(const std::string& secret_key, std::uint64_t session) {
  std::array<std::uint8_t, crypto_auth_hmacsha256_KEYBYTES> secret{};
  static_assert(secret.size() == 32, "a CURVE key");
  zmq_z85_decode(secret.data(), secret_key.c_str());
  std::string text = "VR-OOS session";
  for (int i = 0; i < 8; ++i) text += static_cast<char>((session >> (8 * i)) & 0xff);
  std::array<std::uint8_t, crypto_auth_hmacsha256_BYTES> key;
  crypto_auth_hmacsha256(key.data(), reinterpret_cast<const std::uint8_t*>(text.data()), text.size(), secret.data());
  sodium_memzero(secret.data(), secret.size());
  return {key.begin(), key.end()};
}

}  // namespace bus::detail
