#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

// Protobuf's wire format [Protocol Buffers encoding] without protobuf's library: at a thousand messages a second the
// library's code and tables have left the processor's caches each time they are needed.
namespace bus::detail {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they stand in memory");

enum WireType : std::uint32_t { kVarint = 0, kFixed64 = 1, kBytes = 2, kFixed32 = 5 };

constexpr std::size_t VarintBytes(std::uint64_t value) {
  return (static_cast<std::size_t>(std::bit_width(value | 1)) + 6) / 7;
}

// The interface of WireWriter; only counts the bytes.
class WireCounter {
 public:
  void Tag(std::uint32_t number, WireType) { bytes_ += VarintBytes(std::uint64_t{number} << 3); }
  void Varint(std::uint64_t value) { bytes_ += VarintBytes(value); }
  template <class T>
  void Copy(const T&) {
    bytes_ += sizeof(T);
  }
  void Text(std::uint32_t number, std::string_view text) {
    Tag(number, kBytes);
    Varint(text.size());
    bytes_ += text.size();
  }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  std::size_t bytes_ = 0;
};

// Does not check bounds: the caller has counted the bytes.
class WireWriter {
 public:
  explicit WireWriter(std::uint8_t* out) : at_(out) {}
  void Tag(std::uint32_t number, WireType type) { Varint(number << 3 | type); }
  void Varint(std::uint64_t value) {
    while (value >= 0x80) {
      *at_++ = static_cast<std::uint8_t>(value | 0x80);
      value >>= 7;
    }
    *at_++ = static_cast<std::uint8_t>(value);
  }
  template <class T>
  void Copy(const T& value) {
    std::memcpy(at_, &value, sizeof(value));
    at_ += sizeof(value);
  }
  void Text(std::uint32_t number, std::string_view text) {
    Tag(number, kBytes);
    Varint(text.size());
    std::memcpy(at_, text.data(), text.size());
    at_ += text.size();
  }
  [[nodiscard]] const std::uint8_t* end() const { return at_; }

 private:
  std::uint8_t* at_;
};

// Reads a varint from the front of `bytes`.
inline bool TakeVarint(std::span<const std::uint8_t>* bytes, std::uint64_t* value) {
  *value = 0;
  const std::size_t most = bytes->size() < 10 ? bytes->size() : 10;
  for (std::size_t i = 0; i < most; ++i) {
    const std::uint8_t byte = (*bytes)[i];
    *value |= static_cast<std::uint64_t>(byte & 0x7f) << (7 * i);
    if (byte < 0x80) {
      *bytes = bytes->subspan(i + 1);
      return true;
    }
  }
  return false;
}

struct WireField {
  std::uint32_t number = 0;
  std::uint32_t type = 0;
  std::uint64_t value = 0;              // of a varint, fixed64 or fixed32
  std::span<const std::uint8_t> bytes;  // of kBytes

  [[nodiscard]] bool Is(std::uint32_t wanted, WireType wanted_type) const {
    return number == wanted && type == wanted_type;
  }
};

// Reads field after field. Groups, which no .proto file here has, count as damage.
class WireReader {
 public:
  explicit WireReader(std::span<const std::uint8_t> in) : left_(in) {}

  // False: the end, or bytes that are no field (then is_sound() is false).
  bool Next(WireField* field) {
    if (left_.empty()) return false;
    std::uint64_t tag = 0;
    is_sound_ = TakeVarint(&left_, &tag) && tag >> 3 != 0 && tag <= 0xffff'ffff;
    if (!is_sound_) return false;
    field->number = static_cast<std::uint32_t>(tag >> 3);
    field->type = static_cast<std::uint32_t>(tag & 7);
    switch (field->type) {
      case kVarint:
        is_sound_ = TakeVarint(&left_, &field->value);
        break;
      case kFixed64:
        is_sound_ = TakeNumber<std::uint64_t>(&field->value);
        break;
      case kFixed32:
        is_sound_ = TakeNumber<std::uint32_t>(&field->value);
        break;
      case kBytes: {
        std::uint64_t size = 0;
        is_sound_ = TakeVarint(&left_, &size) && size <= left_.size();
        if (!is_sound_) break;
        field->bytes = left_.first(static_cast<std::size_t>(size));
        left_ = left_.subspan(static_cast<std::size_t>(size));
        break;
      }
      default:
        is_sound_ = false;
    }
    return is_sound_;
  }
  [[nodiscard]] bool is_sound() const { return is_sound_; }

 private:
  template <class T>
  bool TakeNumber(std::uint64_t* value) {
    if (left_.size() < sizeof(T)) return false;
    T number;
    std::memcpy(&number, left_.data(), sizeof(T));
    *value = number;
    left_ = left_.subspan(sizeof(T));
    return true;
  }

  std::span<const std::uint8_t> left_;
  bool is_sound_ = true;
};

// Strings of proto3 are UTF-8 [RFC 3629]: no overlong forms, no surrogates, nothing beyond U+10FFFF.
inline bool IsUtf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<std::uint8_t>(text[i++]);
    if (lead < 0x80) continue;
    const int more = lead >= 0xf0 ? 3 : lead >= 0xe0 ? 2 : 1;
    if (lead < 0xc2 || lead > 0xf4 || text.size() - i < static_cast<std::size_t>(more)) return false;
    std::uint32_t code = lead & (0x3fU >> more);
    for (int k = 0; k < more; ++k) {
      const auto byte = static_cast<std::uint8_t>(text[i++]);
      if ((byte & 0xc0) != 0x80) return false;
      code = code << 6 | (byte & 0x3f);
    }
    const bool is_overlong = more == 2 ? code < 0x800 : more == 3 && code < 0x1'0000;
    if (is_overlong || code > 0x10'ffff || (code >= 0xd800 && code < 0xe000)) return false;
  }
  return true;
}

}  // namespace bus::detail
