#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "bus/figures.hpp"
#include "bus/topics.hpp"
#include "core/messages/logic.hpp"

namespace bus {

// The only place that knows both core's messages and proto/.

template <class M>
constexpr MessageType kMessageTypeOf = MessageType::kNone;
template <>
inline constexpr MessageType kMessageTypeOf<core::DeviceState> = MessageType::kDeviceState;
template <>
inline constexpr MessageType kMessageTypeOf<core::DeviceCommand> = MessageType::kDeviceCommand;
template <>
inline constexpr MessageType kMessageTypeOf<core::HapticProxy> = MessageType::kHapticProxy;
template <>
inline constexpr MessageType kMessageTypeOf<core::ContactSet> = MessageType::kContactSet;
template <>
inline constexpr MessageType kMessageTypeOf<core::PhysicsState> = MessageType::kPhysicsState;
template <>
inline constexpr MessageType kMessageTypeOf<core::Reaction> = MessageType::kReaction;
template <>
inline constexpr MessageType kMessageTypeOf<core::SheetState> = MessageType::kSheetState;
template <>
inline constexpr MessageType kMessageTypeOf<core::LogicStatus> = MessageType::kLogicStatus;
template <>
inline constexpr MessageType kMessageTypeOf<Figures> = MessageType::kFigures;

// What writing a payload returns when there is not enough room. A message of nothing but defaults takes 0 bytes.
constexpr std::size_t kDoesNotFit = ~std::size_t{0};

// Payload of one LATEST message, in one or more parts. Keeps a protobuf message that is used again, so it does not
// allocate once warm. `header` is the envelope's and is neither read nor written here.
template <class M>
class LatestCodec {
 public:
  LatestCodec();
  ~LatestCodec();
  LatestCodec(const LatestCodec&) = delete;
  LatestCodec& operator=(const LatestCodec&) = delete;

  // Parts needed so that each payload stays within `budget` bytes.
  [[nodiscard]] int NumParts(const M& message, std::size_t budget) const noexcept;
  // Returns the payload's size, or kDoesNotFit.
  std::size_t Encode(const M& message, int part, std::size_t budget, std::uint8_t* out, std::size_t capacity) noexcept;
  // Adds one part to `message`. `is_first`: of this message to arrive; resizes its lists. False, with `message` as it
  // was, when the bytes are not such a payload or contradict themselves.
  bool Decode(std::span<const std::uint8_t> payload, bool is_first, M* message) noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// STATE values. EncodeState replaces the content of `bytes`.
template <class M>
void EncodeState(const M& value, std::string* bytes);
template <class M>
bool DecodeState(const std::string& bytes, M* value);

}  // namespace bus
