#include <cmath>

#include "device/haply_messages.hpp"
#include "device/websocket.hpp"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/reader.hpp"

namespace fuzz {
namespace {

// The key and the answer to it of RFC 6455, 1.3.
constexpr const char* kKey = "dGhlIHNhbXBsZSBub25jZQ==";
constexpr const char* kOpening =
    "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n\r\n";

void CheckMessage(const std::string& text) {
  device::HaplyState state;
  if (!device::ReadHaplyState(text, &state)) return;
  double square = 0.0;
  for (const double q : state.quaternion) square += q * q;
  for (const double x : state.position_m) Claim(std::isfinite(x), "places are finite");
  for (const double v : state.velocity_m_per_s) Claim(std::isfinite(v), "velocities are finite");
  Claim(std::abs(square - 1.0) < 1e-9, "the quaternion is a unit");
  const double force_N[3] = {1.0, 2.0, 3.0};
  Claim(!device::WriteHaplyForce(state.device_id, force_N).empty(), "any id can be addressed");
}

}  // namespace

// What a server sends over a WebSocket: as its answer to the opening, or after it. The first byte decides, and is the
// size of the pieces in which the rest arrives.
void FuzzWebSocket(Input input) {
  Reader reader(input);
  const std::uint8_t first = reader.Byte();
  device::WebSocket socket("h", "/", kKey, 1);
  if (first % 4 != 0) socket.Take(kOpening);
  const std::string bytes = TextOf(reader.Rest());
  const std::size_t piece = 1 + first / 4;
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    socket.Take(std::string_view(bytes).substr(at, piece));
    while (const auto text = socket.NextText()) {
      Claim(text->size() <= device::WebSocket::kMaxMessage, "messages are bounded");
      CheckMessage(*text);
    }
  }
  Claim(!socket.is_broken() || !socket.why().empty(), "a fault says why");
}

// One message of Haply's service.
void FuzzHaplyMessage(Input input) {
  CheckMessage(TextOf(input));
}

}  // namespace fuzz
