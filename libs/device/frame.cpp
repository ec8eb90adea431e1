#include "device/frame.hpp"

#include <zlib.h>

#include <bit>
#include <cmath>
#include <cstring>

namespace device {
namespace {

static_assert(std::endian::native == std::endian::little, "frames are copied as they lie in memory");

constexpr std::array<char, 4> kMagic = {'O', 'O', 'S', 'D'};
constexpr std::uint8_t kVersion = 1;
// A quaternion further from a unit is not one that was rounded.
constexpr double kUnitTolerance = 1e-3;

std::uint32_t Crc(const std::uint8_t* bytes, std::size_t size) {
  return static_cast<std::uint32_t>(crc32(0, bytes, static_cast<uInt>(size)));
}

class Writer {
 public:
  explicit Writer(const FrameHeader& header) {
    Bytes(kMagic.data(), kMagic.size());
    Value(kVersion);
    Value(static_cast<std::uint8_t>(header.kind));
    Value(std::uint16_t{0});  // by Finish
    Value(header.sequence);
    Value(header.reflected);
    Value(header.time_ns);
  }
  template <class T>
  void Value(const T& value) {
    Bytes(&value, sizeof value);
  }
  void Bytes(const void* data, std::size_t size) {
    std::memcpy(frame_.bytes.data() + frame_.size, data, size);
    frame_.size += size;
  }
  Frame Finish() {
    const auto length = static_cast<std::uint16_t>(frame_.size + kCrcSize);
    std::memcpy(frame_.bytes.data() + 6, &length, sizeof length);
    Value(Crc(frame_.bytes.data(), frame_.size));
    return frame_;
  }

 private:
  Frame frame_;
};

// Only called with enough bytes: the length of each kind is fixed.
class Cursor {
 public:
  explicit Cursor(const std::uint8_t* at) : at_(at) {}
  template <class T>
  void Value(T* value) {
    Bytes(value, sizeof *value);
  }
  void Bytes(void* to, std::size_t size) {
    std::memcpy(to, at_, size);
    at_ += size;
  }
  // False when a number is not finite.
  template <std::size_t N>
  bool Numbers(double (&values)[N]) {
    Bytes(values, sizeof values);
    bool is_finite = true;
    for (const double value : values) is_finite = is_finite && std::isfinite(value);
    return is_finite;
  }
  bool Number(double* value) {
    Value(value);
    return std::isfinite(*value);
  }

 private:
  const std::uint8_t* at_;
};

std::size_t SizeOf(FrameKind kind) {
  switch (kind) {
    case FrameKind::kDescription:
      return kDescriptionSize;
    case FrameKind::kState:
      return kStateSize;
    case FrameKind::kCommand:
      return kCommandSize;
  }
  return 0;
}

// The ten numbers of a description, in the order of the frame.
template <class Description, class Visit>
void VisitNumbers(Description& d, const Visit& visit) {
  visit(d.rate_hz);
  visit(d.max_force_N);
  visit(d.max_torque_Nm);
  visit(d.max_grip_force_N);
  visit(d.mass_kg);
  visit(d.inertia_kg_m2);
  visit(d.damping_N_s_per_m);
  visit(d.damping_Nm_s_per_rad);
  visit(d.reach_m);
  visit(d.opening_max_m);
}

bool ReadDescription(Cursor cursor, oos_device_description* d) {
  d->size = sizeof *d;
  cursor.Bytes(d->name, sizeof d->name);
  cursor.Bytes(d->serial, sizeof d->serial);
  d->name[sizeof d->name - 1] = 0;
  d->serial[sizeof d->serial - 1] = 0;
  std::uint32_t reserved = 0;
  cursor.Value(&d->flags);
  cursor.Value(&d->sensed);
  cursor.Value(&d->actuated);
  cursor.Value(&reserved);
  bool is_finite = true;
  VisitNumbers(*d, [&](double& number) { is_finite = cursor.Number(&number) && is_finite; });
  return is_finite;
}

bool ReadState(Cursor cursor, const FrameHeader& header, oos_device_state* state) {
  std::uint32_t buttons = 0;
  state->size = sizeof *state;
  state->sequence = header.sequence;
  state->reflected = header.reflected;
  state->device_time_ns = header.time_ns;
  cursor.Value(&state->flags);
  cursor.Value(&buttons);
  state->buttons = buttons;
  bool is_finite = cursor.Numbers(state->X_BD);
  is_finite = cursor.Numbers(state->V_BD) && is_finite;
  is_finite = cursor.Number(&state->opening_m) && is_finite;
  is_finite = cursor.Number(&state->opening_velocity_m_per_s) && is_finite;
  is_finite = cursor.Numbers(state->applied) && is_finite;
  if (!is_finite) return false;
  double square = 0.0;
  for (int i = 0; i < 4; ++i) square += state->X_BD[i] * state->X_BD[i];
  if (!(std::abs(square - 1.0) < kUnitTolerance)) return false;
  const double norm = std::sqrt(square);
  for (int i = 0; i < 4; ++i) state->X_BD[i] /= norm;
  return true;
}

bool ReadCommand(Cursor cursor, const FrameHeader& header, oos_device_command* command, std::uint32_t* flags) {
  std::uint32_t reserved = 0;
  command->size = sizeof *command;
  command->sequence = header.sequence;
  cursor.Value(flags);
  cursor.Value(&reserved);
  bool is_finite = cursor.Numbers(command->F_Do_B);
  is_finite = cursor.Number(&command->grip_force_N) && is_finite;
  is_finite = cursor.Number(&command->brake_N_s_per_m) && is_finite;
  return cursor.Number(&command->brake_Nm_s_per_rad) && is_finite;
}

}  // namespace

Frame EncodeDescription(const FrameHeader& header, const oos_device_description& description) {
  Writer writer(header);
  writer.Bytes(description.name, sizeof description.name);
  writer.Bytes(description.serial, sizeof description.serial);
  writer.Value(description.flags);
  writer.Value(description.sensed);
  writer.Value(description.actuated);
  writer.Value(std::uint32_t{0});
  VisitNumbers(description, [&](const double& number) { writer.Value(number); });
  return writer.Finish();
}

Frame EncodeState(const FrameHeader& header, const oos_device_state& state) {
  Writer writer(header);
  writer.Value(state.flags);
  writer.Value(static_cast<std::uint32_t>(state.buttons));
  writer.Value(state.X_BD);
  writer.Value(state.V_BD);
  writer.Value(state.opening_m);
  writer.Value(state.opening_velocity_m_per_s);
  writer.Value(state.applied);
  return writer.Finish();
}

Frame EncodeCommand(const FrameHeader& header, const oos_device_command& command, std::uint32_t flags) {
  Writer writer(header);
  writer.Value(flags);
  writer.Value(std::uint32_t{0});
  writer.Value(command.F_Do_B);
  writer.Value(command.grip_force_N);
  writer.Value(command.brake_N_s_per_m);
  writer.Value(command.brake_Nm_s_per_rad);
  return writer.Finish();
}

FrameFault DecodeFrame(std::span<const std::uint8_t> bytes, ReadFrame* frame) {
  if (bytes.size() < kHeaderSize + kCrcSize) return FrameFault::kShort;
  if (std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0) return FrameFault::kNoMagic;
  if (bytes[4] != kVersion) return FrameFault::kVersion;
  frame->header.kind = static_cast<FrameKind>(bytes[5]);
  const std::size_t size = SizeOf(frame->header.kind);
  if (size == 0) return FrameFault::kKind;
  std::uint16_t length = 0;
  std::memcpy(&length, bytes.data() + 6, sizeof length);
  if (length != size || bytes.size() != size) return FrameFault::kLength;
  std::uint32_t crc = 0;
  std::memcpy(&crc, bytes.data() + size - kCrcSize, sizeof crc);
  if (crc != Crc(bytes.data(), size - kCrcSize)) return FrameFault::kCrc;
  Cursor cursor(bytes.data() + 8);
  cursor.Value(&frame->header.sequence);
  cursor.Value(&frame->header.reflected);
  cursor.Value(&frame->header.time_ns);
  bool is_valid = false;
  switch (frame->header.kind) {
    case FrameKind::kDescription:
      is_valid = ReadDescription(cursor, &frame->description);
      break;
    case FrameKind::kState:
      is_valid = ReadState(cursor, frame->header, &frame->state);
      break;
    case FrameKind::kCommand:
      is_valid = ReadCommand(cursor, frame->header, &frame->command, &frame->command_flags);
      break;
  }
  return is_valid ? FrameFault::kNone : FrameFault::kNotFinite;
}

const char* Describe(FrameFault fault) {
  switch (fault) {
    case FrameFault::kNone:
      return "valid";
    case FrameFault::kShort:
      return "shorter than a frame";
    case FrameFault::kNoMagic:
      return "does not begin with OOSD";
    case FrameFault::kVersion:
      return "of another version of the protocol";
    case FrameFault::kKind:
      return "of a kind that does not exist";
    case FrameFault::kLength:
      return "not as long as its kind is";
    case FrameFault::kCrc:
      return "its CRC is wrong";
    case FrameFault::kNotFinite:
      return "has a number that is not finite, or a quaternion that is not a unit";
  }
  return "";
}

}  // namespace device
