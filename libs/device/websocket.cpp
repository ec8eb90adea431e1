#include "device/websocket.hpp"

#include <algorithm>
#include <cctype>

#include "device/sha1.hpp"

namespace device {
namespace {

constexpr std::string_view kGuid = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";  // [RFC 6455, 1.3]
constexpr std::size_t kMaxOpening = 8192;

enum Opcode : std::uint8_t { kContinuation = 0, kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10 };

std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

// The value of a header, whose name is given in small letters; empty: it is not there.
std::string_view HeaderOf(std::string_view opening, std::string_view name) {
  while (!opening.empty()) {
    const std::size_t end = std::min(opening.find("\r\n"), opening.size());
    const std::string_view line = opening.substr(0, end);
    opening.remove_prefix(std::min(end + 2, opening.size()));
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos || Lower(line.substr(0, colon)) != name) continue;
    std::string_view value = line.substr(colon + 1);
    while (!value.empty() && value.front() == ' ') value.remove_prefix(1);
    while (!value.empty() && value.back() == ' ') value.remove_suffix(1);
    return value;
  }
  return {};
}

}  // namespace

WebSocket::WebSocket(std::string_view host, std::string_view path, std::string_view key, std::uint32_t mask)
    : mask_(mask) {
  out_ = "GET " + std::string(path) + " HTTP/1.1\r\nHost: " + std::string(host) +
         "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: " + std::string(key) +
         "\r\nSec-WebSocket-Version: 13\r\n\r\n";
  const auto digest = Sha1(std::string(key) + std::string(kGuid));
  accept_ = Base64(digest.data(), digest.size());
}

void WebSocket::Take(std::string_view bytes) {
  if (is_broken()) return;
  in_ += bytes;
  if (!is_open_) ReadOpening();
}

void WebSocket::ReadOpening() {
  const std::size_t end = in_.find("\r\n\r\n");
  if (end == std::string::npos) {
    if (in_.size() > kMaxOpening) why_ = "the answer is no WebSocket's";
    return;
  }
  const std::string opening = in_.substr(0, end);
  in_.erase(0, end + 4);
  const bool is_switching = opening.rfind("HTTP/1.1 101", 0) == 0;
  const bool is_upgrade = Lower(HeaderOf(opening, "upgrade")) == "websocket";
  if (!is_switching || !is_upgrade || HeaderOf(opening, "sec-websocket-accept") != accept_) {
    why_ = "the server does not speak WebSocket: " + opening.substr(0, opening.find("\r\n"));
    return;
  }
  is_open_ = true;
}

std::optional<std::string> WebSocket::NextText() {
  while (is_open_ && !is_broken() && ReadFrame()) {
    if (!is_message_whole_) continue;
    is_message_whole_ = false;
    std::string text;
    text.swap(message_);
    return text;
  }
  return std::nullopt;
}

//   byte 0: end of message, 3 reserved bits, opcode; byte 1: masked, length or 126 (2 more bytes) or 127 (8 more);
//   payload
bool WebSocket::ReadFrame() {
  const auto byte = [this](std::size_t i) { return static_cast<std::uint8_t>(in_[i]); };
  if (in_.size() < 2) return false;
  const bool is_last = (byte(0) & 0x80) != 0;
  const std::uint8_t opcode = byte(0) & 0x0F;
  if ((byte(0) & 0x70) != 0 || (byte(1) & 0x80) != 0) {
    why_ = "a frame has reserved bits or a mask";  // a server never masks
    return false;
  }
  std::uint64_t length = byte(1);
  std::size_t head = 2;
  if (length >= 126) {
    const std::size_t extra = length == 126 ? 2 : 8;
    if (in_.size() < head + extra) return false;
    length = 0;
    for (std::size_t i = 0; i < extra; ++i) length = length << 8 | byte(head + i);
    head += extra;
  }
  const bool is_control = (opcode & 0x08) != 0;
  if (length > kMaxMessage || message_.size() + length > kMaxMessage || (is_control && (length > 125 || !is_last))) {
    why_ = "a message is too long";
    return false;
  }
  if (in_.size() < head + length) return false;
  const std::string payload = in_.substr(head, static_cast<std::size_t>(length));
  in_.erase(0, head + static_cast<std::size_t>(length));
  switch (opcode) {
    case kPing:
      Send(kPong, payload);
      return true;
    case kPong:
      return true;
    case kClose:
      why_ = "the server has closed the connection";
      return false;
    case kText:
    case kBinary:
    case kContinuation:
      if ((opcode == kContinuation) != is_in_message_) {
        why_ = "fragments of messages are out of order";
        return false;
      }
      message_ += payload;
      is_in_message_ = !is_last;
      is_message_whole_ = is_last;
      return true;
    default:
      why_ = "a frame of unknown kind";
      return false;
  }
}

void WebSocket::SendText(std::string_view text) {
  if (is_open_ && !is_broken()) Send(kText, text);
}

// What a client sends is masked, so that no proxy takes it for something else.
void WebSocket::Send(std::uint8_t opcode, std::string_view payload) {
  out_ += static_cast<char>(0x80 | opcode);
  if (payload.size() < 126) {
    out_ += static_cast<char>(0x80 | payload.size());
  } else {
    const std::size_t extra = payload.size() < 65536 ? 2 : 8;
    out_ += static_cast<char>(0x80 | (extra == 2 ? 126 : 127));
    for (std::size_t i = extra; i-- > 0;)
      out_ += static_cast<char>(static_cast<std::uint64_t>(payload.size()) >> (8 * i));
  }
  mask_ = mask_ * 1664525U + 1013904223U;  // [Numerical Recipes]; it need not be a secret from this machine
  char mask[4];
  for (int i = 0; i < 4; ++i) mask[i] = static_cast<char>(mask_ >> (8 * i));
  out_.append(mask, 4);
  for (std::size_t i = 0; i < payload.size(); ++i) out_ += static_cast<char>(payload[i] ^ mask[i % 4]);
}

std::string WebSocket::TakeOutput() {
  std::string output;
  output.swap(out_);
  return output;
}

}  // namespace device
