#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "bus/wire/values.hpp"
#include "core/messages/bulk_fields.hpp"
#include "core/messages/camera_fields.hpp"
#include "core/messages/device_fields.hpp"
#include "core/messages/haptic_fields.hpp"
#include "core/messages/logic_fields.hpp"
#include "core/messages/physics_fields.hpp"
#include "core/messages/rays_fields.hpp"
#include "core/messages/viewing_fields.hpp"

// Encodes messages by their fields (core/messages/fields.hpp): byte for byte what protobuf's library writes.
namespace bus::detail {

struct Range {
  std::size_t first = 0, count = 0;
};

template <class M>
using FieldsTuple = std::remove_cvref_t<decltype(core::FieldsOf<M>::kAll)>;

template <class... F>
constexpr std::size_t CountLists(const std::tuple<F...>&) {
  return (std::size_t{0} + ... + (F::kIsList ? 1 : 0));
}
template <class M>
constexpr std::size_t kNumLists = CountLists(core::FieldsOf<M>::kAll);

// The range of each list that one part of a message holds.
template <class M>
using Part = std::array<Range, kNumLists<M>>;

// The value of an item that is no struct.
template <std::uint32_t number, Wire wire, class Item>
struct OnlyColumn {
  static constexpr std::uint32_t kNumber = number;
  static constexpr Wire kWire = wire;
  using Type = Item;
  template <class I>
  static constexpr auto& Of(I& item) {
    return item;
  }
};

// visit(column) for each array that the list travels as.
template <class L, class Visit>
constexpr void ForEachColumn(Visit&& visit) {
  if constexpr (L::kValueNumber != 0) {
    visit(OnlyColumn<L::kValueNumber, L::kValueWire, typename L::Item>{});
  } else {
    core::ForEachField<typename L::Item>(visit);
  }
}

// --- Sizes

template <class F>
constexpr std::size_t MaxColumnBytesPerItem() {
  return MaxValueBytes<F::kWire, typename F::Type>();
}

template <class L>
constexpr std::size_t MaxItemBytes() {
  std::size_t bytes = 0;
  ForEachColumn<L>([&bytes](auto column) { bytes += MaxColumnBytesPerItem<decltype(column)>(); });
  return bytes;
}

constexpr std::size_t TagBytes(std::uint32_t number) {
  return VarintBytes(std::uint64_t{number} << 3);
}

// Upper bound of the bytes of everything but list items; a packed array's length takes at most 2 within a datagram.
template <class M>
constexpr std::size_t MaxBytesBesideItems() {
  std::size_t bytes = 0;
  core::ForEachField<M>([&bytes](auto field) {
    using F = decltype(field);
    if constexpr (F::kIsList) {
      for (const std::uint32_t number : {F::kSizeNumber, F::kFirstNumber}) {
        bytes += TagBytes(number) + VarintBytes(F::Type::kCapacity);
      }
      ForEachColumn<F>([&bytes](auto column) { bytes += TagBytes(column.kNumber) + 2; });
    } else {
      bytes += TagBytes(F::kNumber) + MaxValueBytes<F::kWire, typename F::Type>();
      if constexpr (IsCompound<typename F::Type>) bytes += VarintBytes(sizeof(Numbers<typename F::Type>));
    }
  });
  if constexpr (requires { core::FieldsOf<M>::kSpareBytes; }) bytes += core::FieldsOf<M>::kSpareBytes;
  return bytes;
}

// --- Parts: lists are taken from the last to the first, each part filled up to the budget.

template <class M>
class PartPlan {
 public:
  PartPlan(const M& message, std::size_t budget) : room_(RoomFor(budget)) {
    std::size_t list = 0;
    core::ForEachField<M>([&](auto field) {
      if constexpr (decltype(field)::kIsList) {
        sizes_[list] = field.Of(message).size();
        item_bytes_[list++] = MaxItemBytes<decltype(field)>();
      }
    });
  }

  [[nodiscard]] const Part<M>& part() const { return part_; }
  void Next() {
    std::size_t left = room_;
    for (std::size_t i = kNumLists<M>; i-- > 0;) {
      Range& range = part_[i];
      range.first += range.count;
      range.count = std::min(sizes_[i] - range.first, left / item_bytes_[i]);
      left -= range.count * item_bytes_[i];
    }
  }
  [[nodiscard]] bool is_last() const {
    for (std::size_t i = 0; i < kNumLists<M>; ++i) {
      if (part_[i].first + part_[i].count != sizes_[i]) return false;
    }
    return true;
  }

 private:
  // For at least one item of any list.
  static std::size_t RoomFor(std::size_t budget) {
    std::size_t item = 0;
    core::ForEachField<M>([&item](auto field) {
      if constexpr (decltype(field)::kIsList) item = std::max(item, MaxItemBytes<decltype(field)>());
    });
    constexpr std::size_t kBeside = MaxBytesBesideItems<M>();
    return budget > kBeside + item ? budget - kBeside : item;
  }

  std::size_t room_;
  std::array<std::size_t, kNumLists<M>> sizes_{}, item_bytes_{};
  Part<M> part_{};
};

template <class M>
Part<M> PartOf(const M& message, int part, std::size_t budget) {
  if constexpr (kNumLists<M> == 0) {
    return {};
  } else {
    PartPlan<M> plan(message, budget);
    for (int i = 0; i <= part; ++i) plan.Next();
    return plan.part();
  }
}

template <class M>
int CountParts(const M& message, std::size_t budget) {
  int parts = 1;
  if constexpr (kNumLists<M> != 0) {
    PartPlan<M> plan(message, budget);
    for (plan.Next(); !plan.is_last(); plan.Next()) ++parts;
  }
  return parts;
}

// --- Fields. proto3 leaves out what is zero.

template <Wire wire, class Sink>
void WriteNumber(std::uint64_t bits, Sink* sink) {
  if constexpr (IsVarint(wire)) {
    sink->Varint(bits);
  } else if constexpr (FixedBytes(wire) == 4) {
    sink->Copy(static_cast<std::uint32_t>(bits));
  } else {
    sink->Copy(bits);
  }
}

template <Wire wire, IsNumber T, class Sink>
void WriteNumberField(std::uint32_t number, T value, Sink* sink) {
  const std::uint64_t bits = ToBits<wire>(value);
  if (bits == 0) return;
  sink->Tag(number, TypeOf(wire));
  WriteNumber<wire>(bits, sink);
}

template <class M, class Sink>
void WriteFields(const M& message, const Part<M>& part, Sink* sink);

template <class M>
std::size_t CountBytes(const M& message, const Part<M>& part) {
  WireCounter counter;
  WriteFields(message, part, &counter);
  return counter.bytes();
}

template <class F, class Sink, class T>
void WriteField(F, const T& value, Sink* sink) {
  if constexpr (IsCompound<T>) {
    const auto numbers = NumbersOf(value);
    sink->Tag(F::kNumber, kBytes);
    sink->Varint(sizeof(numbers));
    sink->Copy(numbers);
  } else if constexpr (IsNumber<T>) {
    WriteNumberField<F::kWire>(F::kNumber, value, sink);
  } else if constexpr (std::is_same_v<T, std::string>) {
    if (!value.empty()) sink->Text(F::kNumber, value);
  } else if constexpr (F::kWire == Wire::kString) {
    for (const std::string& text : value) sink->Text(F::kNumber, text);
  } else {
    for (const auto& item : value) {
      sink->Tag(F::kNumber, kBytes);
      sink->Varint(CountBytes(item, {}));
      WriteFields(item, {}, sink);
    }
  }
}

template <class C, class Sink, class Items>
void WriteColumnValues(C column, const Items& items, Range range, Sink* sink) {
  for (std::size_t i = range.first; i < range.first + range.count; ++i) {
    const auto& value = column.Of(items[i]);
    if constexpr (IsCompound<typename C::Type>) {
      sink->Copy(NumbersOf(value));
    } else {
      WriteNumber<C::kWire>(ToBits<C::kWire>(value), sink);
    }
  }
}

template <class C, class Sink, class Items>
void WriteColumn(C column, const Items& items, Range range, Sink* sink) {
  if (range.count == 0) return;
  if constexpr (C::kWire == Wire::kString) {
    for (std::size_t i = range.first; i < range.first + range.count; ++i) {
      sink->Text(C::kNumber, column.Of(items[i]));
    }
  } else {
    std::size_t bytes = range.count * MaxValueBytes<C::kWire, typename C::Type>();
    if constexpr (!IsCompound<typename C::Type> && IsVarint(C::kWire)) {
      WireCounter counter;
      WriteColumnValues(column, items, range, &counter);
      bytes = counter.bytes();
    }
    sink->Tag(C::kNumber, kBytes);
    sink->Varint(bytes);
    WriteColumnValues(column, items, range, sink);
  }
}

template <class Sink>
void WriteCount(std::uint32_t number, std::size_t count, Sink* sink) {
  if (number != 0) WriteNumberField<Wire::kUint64>(number, count, sink);
}

template <class M, class Sink>
void WriteFields(const M& message, const Part<M>& part, Sink* sink) {
  [[maybe_unused]] std::size_t list = 0;
  core::ForEachField<M>([&](auto field) {
    using F = decltype(field);
    const auto& value = field.Of(message);
    if constexpr (F::kIsList) {
      const Range range = part[list++];
      WriteCount(F::kSizeNumber, value.size(), sink);
      WriteCount(F::kFirstNumber, range.first, sink);
      ForEachColumn<F>([&](auto column) { WriteColumn(column, value, range, sink); });
    } else {
      WriteField(field, value, sink);
    }
  });
}

// The lists as a whole.
template <class M>
Part<M> WholeOf(const M& message) {
  Part<M> part{};
  [[maybe_unused]] std::size_t list = 0;
  core::ForEachField<M>([&](auto field) {
    if constexpr (decltype(field)::kIsList) part[list++].count = field.Of(message).size();
  });
  return part;
}

}  // namespace bus::detail
