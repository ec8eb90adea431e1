#pragma once

#include <array>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "bus/wire/encode.hpp"

// Decodes messages by their fields (core/messages/fields.hpp). Accepts what protobuf's library accepts and the struct
// can hold. All bytes are checked before the message is written. Fields that are absent become zero, whatever the
// struct's defaults; unknown fields are skipped.
namespace bus::detail {

template <class M>
bool DecodeMessage(std::span<const std::uint8_t> in, bool is_first, M* message);

// Holds the value of a field F until the whole message has proven sound.
//   Take     false: the bytes are of another field. May set *is_sound to false.
//   IsSound  whether the value is complete; `message` has what other parts brought
//   Store    writes it into the message
template <class F>
struct Slot;

template <class F>
concept IsNumberField = !F::kIsList && IsNumber<typename F::Type>;
template <class F>
concept IsCompoundField = !F::kIsList && IsCompound<typename F::Type>;
template <class F>
concept IsTextField = !F::kIsList && std::is_same_v<typename F::Type, std::string>;

template <IsNumberField F>
struct Slot<F> {
  using T = typename F::Type;
  std::uint64_t bits = 0;

  bool Take(const WireField& field, bool*) {
    if (!field.Is(F::kNumber, TypeOf(F::kWire))) return false;
    bits = field.value;
    return true;
  }
  template <class M>
  [[nodiscard]] bool IsSound(const M&, bool) const {
    return IsInRange<F::kWire, T>(bits);
  }
  template <class M>
  void Store(M* message, std::span<const std::uint8_t>, bool) {
    F::Of(*message) = FromBits<F::kWire, T>(bits);
  }
};

// A packed array, which may come in pieces or unpacked.
template <IsCompoundField F>
struct Slot<F> {
  Numbers<typename F::Type> numbers;
  std::size_t count = 0;

  bool Take(const WireField& field, bool* is_sound) {
    constexpr std::size_t kBytesEach = sizeof(numbers[0]);
    if (field.Is(F::kNumber, kBytes)) {
      if (count == 0 && field.bytes.size() == sizeof(numbers)) {  // usually in one piece
        std::memcpy(numbers.data(), field.bytes.data(), sizeof(numbers));
        count = numbers.size();
        return true;
      }
      const std::size_t added = field.bytes.size() / kBytesEach;
      *is_sound = *is_sound && field.bytes.size() % kBytesEach == 0 && added <= numbers.size() - count;
      if (!*is_sound) return true;
      std::memcpy(numbers.data() + count, field.bytes.data(), field.bytes.size());
      count += added;
      return true;
    }
    if (!field.Is(F::kNumber, TypeOf(F::kWire))) return false;
    *is_sound = *is_sound && count < numbers.size();
    if (*is_sound) std::memcpy(&numbers[count++], &field.value, kBytesEach);
    return true;
  }
  template <class M>
  [[nodiscard]] bool IsSound(const M&, bool) const {
    return count == numbers.size() || (F::kMayLack && count == 0);
  }
  template <class M>
  void Store(M* message, std::span<const std::uint8_t>, bool) {
    if (count == 0) {
      F::Of(*message) = typename F::Type{};
    } else {
      Assign(numbers, &F::Of(*message));
    }
  }
};

inline std::string_view TextOf(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

template <IsTextField F>
struct Slot<F> {
  std::string_view text;

  bool Take(const WireField& field, bool* is_sound) {
    if (!field.Is(F::kNumber, kBytes)) return false;
    text = TextOf(field.bytes);
    *is_sound = *is_sound && (F::kWire == Wire::kBytes || IsUtf8(text));
    return true;
  }
  template <class M>
  [[nodiscard]] bool IsSound(const M&, bool) const {
    return true;
  }
  template <class M>
  void Store(M* message, std::span<const std::uint8_t>, bool) {
    F::Of(*message) = text;
  }
};

// A std::vector of texts or messages.
template <class F>
requires(!IsNumberField<F> && !IsCompoundField<F> && !IsTextField<F> && !F::kIsList) struct Slot<F> {
  typename F::Type values;

  bool Take(const WireField& field, bool* is_sound) {
    if (!field.Is(F::kNumber, kBytes)) return false;
    if constexpr (F::kWire == Wire::kString) {
      values.emplace_back(TextOf(field.bytes));
      *is_sound = *is_sound && IsUtf8(values.back());
    } else {
      *is_sound = *is_sound && DecodeMessage(field.bytes, true, &values.emplace_back());
    }
    return true;
  }
  template <class M>
  [[nodiscard]] bool IsSound(const M&, bool) const {
    return true;
  }
  template <class M>
  void Store(M* message, std::span<const std::uint8_t>, bool) {
    F::Of(*message) = std::move(values);
  }
};

// --- Lists: the columns are counted and checked first, and read in a second pass once all are sound. Usually a column
// comes in one piece, which is remembered.

// Whether the field is of column C, packed or not.
template <class C>
bool IsOf(const WireField& field) {
  return field.number == C::kNumber && (field.type == kBytes || field.type == std::uint32_t{TypeOf(C::kWire)});
}

template <class C>
constexpr std::size_t NumbersPerItem() {
  if constexpr (IsCompound<typename C::Type>) {
    return std::tuple_size_v<Numbers<typename C::Type>>;
  } else {
    return 1;
  }
}

// Counts the numbers (or texts) of a column.
template <class C>
bool CountColumn(const WireField& field, std::size_t* count) {
  if constexpr (C::kWire == Wire::kString) {
    ++*count;
    return IsUtf8(TextOf(field.bytes));
  } else if constexpr (IsVarint(C::kWire)) {
    return ForEachNumber<C::kWire>(field, [count](std::uint64_t bits) {
      ++*count;
      return IsInRange<C::kWire, typename C::Type>(bits);
    });
  } else {
    *count += field.type == kBytes ? field.bytes.size() / FixedBytes(C::kWire) : 1;
    return field.type != kBytes || field.bytes.size() % FixedBytes(C::kWire) == 0;
  }
}

template <class T>
struct Unfinished {
  using Type = std::array<float, 1>;  // not needed
};
template <IsCompound T>
struct Unfinished<T> {
  using Type = Numbers<T>;
};

// Puts the numbers of a column into the items, one after the other.
template <class C, class Items>
class ColumnFiller {
 public:
  ColumnFiller(Items* items, std::size_t first) : items_(items), at_(first) {}

  // False: the field is of another column.
  bool Take(const WireField& field) {
    if (!IsOf<C>(field)) return false;
    if constexpr (C::kWire == Wire::kString) {
      C::Of((*items_)[at_++]) = TextOf(field.bytes);
    } else if constexpr (IsCompound<typename C::Type>) {
      TakeCompounds(field);
    } else {
      ForEachNumber<C::kWire>(field, [this](std::uint64_t bits) {
        C::Of((*items_)[at_++]) = FromBits<C::kWire, typename C::Type>(bits);
        return true;
      });
    }
    return true;
  }

 private:
  void TakeCompounds(const WireField& field) {
    if (field.type == kBytes) return TakeBytes(field.bytes);
    TakeBytes({reinterpret_cast<const std::uint8_t*>(&field.value), sizeof(numbers_[0])});
  }
  void TakeBytes(std::span<const std::uint8_t> left) {
    auto* const bytes = reinterpret_cast<std::uint8_t*>(numbers_.data());
    while (num_bytes_ == 0 && left.size() >= sizeof(numbers_)) {  // usually whole items
      std::memcpy(bytes, left.data(), sizeof(numbers_));
      left = left.subspan(sizeof(numbers_));
      Assign(numbers_, &C::Of((*items_)[at_++]));
    }
    while (!left.empty()) {
      const std::size_t taken = std::min(sizeof(numbers_) - num_bytes_, left.size());
      std::memcpy(bytes + num_bytes_, left.data(), taken);
      left = left.subspan(taken);
      num_bytes_ += taken;
      if (num_bytes_ < sizeof(numbers_)) return;
      Assign(numbers_, &C::Of((*items_)[at_++]));
      num_bytes_ = 0;
    }
  }

  Items* items_;
  std::size_t at_;
  typename Unfinished<typename C::Type>::Type numbers_{};  // of an item split over two pieces
  std::size_t num_bytes_ = 0;
};

template <class L>
constexpr auto ColumnsOf() {
  if constexpr (L::kValueNumber != 0) {
    return std::tuple{OnlyColumn<L::kValueNumber, L::kValueWire, typename L::Item>{}};
  } else {
    return core::FieldsOf<typename L::Item>::kAll;
  }
}

template <class F>
requires(F::kIsList) struct Slot<F> {
  static constexpr auto kColumns = ColumnsOf<F>();
  static constexpr std::size_t kNumColumns = std::tuple_size_v<decltype(kColumns)>;
  std::uint32_t size = 0, first = 0;
  std::array<std::size_t, kNumColumns> counts{};      // of numbers
  std::array<std::size_t, kNumColumns> num_pieces{};  // fields that a column came in
  std::array<WireField, kNumColumns> pieces{};        // the last one of each column

  bool Take(const WireField& field, bool* is_sound) {
    if (F::kSizeNumber != 0 && field.Is(F::kSizeNumber, kVarint)) {
      size = static_cast<std::uint32_t>(field.value);
      return true;
    }
    if (F::kFirstNumber != 0 && field.Is(F::kFirstNumber, kVarint)) {
      first = static_cast<std::uint32_t>(field.value);
      return true;
    }
    std::size_t i = 0;
    return std::apply([&](auto... column) { return (TakeColumn<decltype(column)>(field, i++, is_sound) || ...); },
                      kColumns);
  }

  // A part's items must lie within the total size that it declares, and each must have all of its values.
  template <class M>
  [[nodiscard]] bool IsSound(const M& message, bool is_first) const {
    std::size_t i = 0;
    const std::size_t count = num_items();
    const bool is_complete = std::apply(
        [&](auto... column) { return ((counts[i++] == count * NumbersPerItem<decltype(column)>()) && ...); }, kColumns);
    if constexpr (F::kSizeNumber == 0) return is_complete;
    if constexpr (requires { F::Type::kCapacity; }) {
      if (size > F::Type::kCapacity) return false;
    }
    return is_complete && first + std::uint64_t{count} <= size && (is_first || F::Of(message).size() == size);
  }

  template <class M>
  void Store(M* message, std::span<const std::uint8_t> in, bool is_first) {
    auto& items = F::Of(*message);
    if (is_first) items.resize(F::kSizeNumber == 0 ? num_items() : size);
    if (num_items() == 0) return;
    using Items = std::remove_reference_t<decltype(items)>;
    std::apply(
        [&](auto... column) {
          std::tuple fillers{ColumnFiller<decltype(column), Items>(&items, first)...};
          if (std::all_of(num_pieces.begin(), num_pieces.end(), [](std::size_t n) { return n == 1; })) {
            std::size_t i = 0;
            std::apply([&](auto&... filler) { (filler.Take(pieces[i++]), ...); }, fillers);
            return;
          }
          WireReader reader(in);
          WireField field;
          while (reader.Next(&field)) {
            std::apply([&field](auto&... filler) { (void)(filler.Take(field) || ...); }, fillers);
          }
        },
        kColumns);
  }

  [[nodiscard]] bool HasWholeRows(std::uint64_t row) const { return row == 0 ? size == 0 : size % row == 0; }

 private:
  template <class C>
  bool TakeColumn(const WireField& field, std::size_t i, bool* is_sound) {
    if (!IsOf<C>(field)) return false;
    ++num_pieces[i];
    pieces[i] = field;
    *is_sound = CountColumn<C>(field, &counts[i]) && *is_sound;
    return true;
  }
  [[nodiscard]] std::size_t num_items() const {
    using First = std::remove_cvref_t<decltype(std::get<0>(kColumns))>;
    return counts[0] / NumbersPerItem<First>();
  }
};

// --- Messages

template <class Fields>
struct Slots;
template <class... F>
struct Slots<std::tuple<F...>> {
  std::tuple<Slot<F>...> all;

  void Take(const WireField& field, bool* is_sound) {
    std::apply([&](auto&... slot) { (void)(slot.Take(field, is_sound) || ...); }, all);
  }
  template <class M>
  [[nodiscard]] bool IsSound(const M& message, bool is_first) const {
    return std::apply([&](const auto&... slot) { return (slot.IsSound(message, is_first) && ...); }, all) &&
           (HasWholeRows<F>() && ...);
  }
  template <class M>
  void Store(M* message, std::span<const std::uint8_t> in, bool is_first) {
    std::apply([&](auto&... slot) { (slot.Store(message, in, is_first), ...); }, all);
  }

 private:
  template <class L>
  [[nodiscard]] bool HasWholeRows() const {
    if constexpr (L::kIsList) {
      if constexpr (L::kRowNumber != 0) {
        return std::get<Slot<L>>(all).HasWholeRows((std::uint64_t{0} + ... + NumberAt<F, L::kRowNumber>()));
      }
    }
    return true;
  }
  // The value of F if that is its number, otherwise 0.
  template <class F1, std::uint32_t number>
  [[nodiscard]] std::uint64_t NumberAt() const {
    if constexpr (!F1::kIsList) {
      if constexpr (F1::kNumber == number) return std::get<Slot<F1>>(all).bits;
    }
    return 0;
  }
};

template <class M>
bool DecodeMessage(std::span<const std::uint8_t> in, bool is_first, M* message) {
  Slots<FieldsTuple<M>> slots;
  bool is_sound = true;
  WireReader reader(in);
  WireField field;
  while (is_sound && reader.Next(&field)) slots.Take(field, &is_sound);
  if (!is_sound || !reader.is_sound() || !slots.IsSound(*message, is_first)) return false;
  slots.Store(message, in, is_first);
  return true;
}

}  // namespace bus::detail
