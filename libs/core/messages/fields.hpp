#pragma once

#include <cstdint>
#include <tuple>
#include <type_traits>

// How a message describes its fields: FieldsOf<M>::kAll, which proto/generate.py makes of the .proto file. The codec
// (bus/wire/codec.hpp) and the steps of recordings (replay/fields.hpp) go through it, so that no field is listed again.
namespace core {

// Type of a value on the wire [Protocol Buffers encoding].
enum class Wire : std::uint8_t {
  kBool,
  kUint32,
  kUint64,
  kSint32,
  kSint64,
  kFixed32,
  kFixed64,
  kFloat,
  kDouble,
  kString,
  kMessage,
  kBytes,  // not text: any bytes
};

namespace detail {
template <class M, class T>
T TypeOfMember(T M::*);
}  // namespace detail

// A field, or the column of a list: number and type on the wire, member of the struct. An array of numbers that
// `may_lack` is zero, a pose the identity, when it is not in the message.
template <std::uint32_t number, Wire wire, auto member, bool may_lack = false>
struct Field {
  static constexpr bool kIsList = false;
  static constexpr bool kMayLack = may_lack;
  static constexpr std::uint32_t kNumber = number;
  static constexpr Wire kWire = wire;
  using Type = decltype(detail::TypeOfMember(member));

  const char* name;

  template <class M>
  static constexpr auto& Of(M& message) {
    return message.*member;
  }
};

// A list of structs, or of values where `value_number` is given; on the wire it is an array per member of the struct.
// The numbers are those of the fields that hold how many items there are in all parts, which is the first of this part,
// and how many items make a row; 0: there is no such field.
template <std::uint32_t size_number, std::uint32_t first_number, auto member, std::uint32_t row_number = 0,
          std::uint32_t value_number = 0, Wire value_wire = Wire::kMessage>
struct ListField {
  static constexpr bool kIsList = true;
  static constexpr std::uint32_t kSizeNumber = size_number;
  static constexpr std::uint32_t kFirstNumber = first_number;
  static constexpr std::uint32_t kRowNumber = row_number;
  static constexpr std::uint32_t kValueNumber = value_number;
  static constexpr Wire kValueWire = value_wire;
  using Type = decltype(detail::TypeOfMember(member));
  using Item = std::remove_cvref_t<decltype(std::declval<Type&>()[0])>;

  const char* name;

  template <class M>
  static constexpr auto& Of(M& message) {
    return message.*member;
  }
};

template <class M>
struct FieldsOf;

template <class M>
concept HasFields = requires {
  FieldsOf<M>::kAll;
};

// visit(field) for each field of M, in their order.
template <HasFields M, class Visit>
constexpr void ForEachField(Visit&& visit) {
  std::apply([&visit](const auto&... field) { (visit(field), ...); }, FieldsOf<M>::kAll);
}

}  // namespace core
