#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace device {

// A client's side of a WebSocket [RFC 6455], without a socket: bytes in, texts out, and the other way round. What a
// server sends is foreign: any bytes are allowed.
class WebSocket {
 public:
  // Longer messages are a fault: a device's state has some thousand bytes.
  static constexpr std::size_t kMaxMessage = 65536;

  // `key`: 16 bytes as Base64, another one for each connection. `mask`: starts the masks of what is sent.
  WebSocket(std::string_view host, std::string_view path, std::string_view key, std::uint32_t mask);

  // Takes what came.
  void Take(std::string_view bytes);
  // The next whole message, if one is there.
  std::optional<std::string> NextText();
  void SendText(std::string_view text);
  // Bytes that are to be sent, since the last call: the request to open, messages, answers to pings.
  std::string TakeOutput();

  [[nodiscard]] bool is_open() const { return is_open_; }
  // The connection is of no more use, and why.
  [[nodiscard]] bool is_broken() const { return !why_.empty(); }
  [[nodiscard]] const std::string& why() const { return why_; }

 private:
  void ReadOpening();
  // One frame at the beginning of in_. False: it is not all there, or broken.
  bool ReadFrame();
  void Send(std::uint8_t opcode, std::string_view payload);

  std::string accept_;  // what the server must answer to the key
  std::string in_, out_;
  std::string message_;  // its fragments so far
  bool is_message_whole_ = false;
  bool is_in_message_ = false;
  bool is_open_ = false;
  std::uint32_t mask_;
  std::string why_;
};

}  // namespace device
