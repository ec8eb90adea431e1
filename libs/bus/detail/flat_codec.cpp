#include "bus/detail/flat_codec.hpp"

#include <array>
#include <bit>
#include <cstring>

#include "bus/codec.hpp"

namespace bus::detail {
namespace {

static_assert(std::endian::native == std::endian::little, "doubles are copied as they stand in memory");

enum WireType : std::uint32_t { kVarint = 0, kFixed64 = 1, kBytes = 2, kFixed32 = 5 };

using PoseValues = std::array<double, 7>;
using VectorValues = std::array<double, 6>;

PoseValues ValuesOf(const core::Pose& X) {
  return {X.rotation.w, X.rotation.x, X.rotation.y, X.rotation.z, X.translation.x, X.translation.y, X.translation.z};
}
VectorValues ValuesOf(const glm::dvec3& a, const glm::dvec3& b) {
  return {a.x, a.y, a.z, b.x, b.y, b.z};
}
VectorValues ValuesOf(const core::Twist& V) {
  return ValuesOf(V.angular_rad_per_s, V.linear_m_per_s);
}
VectorValues ValuesOf(const core::Wrench& F) {
  return ValuesOf(F.force_N, F.torque_Nm);
}

// Fields in the order of their numbers; proto3 leaves out what is zero.
class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> out) : at_(out.data()), end_(out.data() + out.size()), begin_(out.data()) {}

  void Varint(std::uint32_t number, std::uint64_t value) {
    if (value == 0 || !HasRoom(15)) return;
    Put(number << 3 | kVarint);
    Put(value);
  }
  void Zigzag(std::uint32_t number, std::int64_t value) {
    Varint(number, (static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63));
  }
  void Fixed64(std::uint32_t number, std::uint64_t value) {
    if (value == 0 || !HasRoom(13)) return;
    Put(number << 3 | kFixed64);
    std::memcpy(at_, &value, sizeof(value));
    at_ += sizeof(value);
  }
  void Double(std::uint32_t number, double value) { Fixed64(number, std::bit_cast<std::uint64_t>(value)); }
  template <std::size_t N>
  void Doubles(std::uint32_t number, const std::array<double, N>& values) {
    if (!HasRoom(10 + sizeof(values))) return;
    Put(number << 3 | kBytes);
    Put(sizeof(values));
    std::memcpy(at_, values.data(), sizeof(values));
    at_ += sizeof(values);
  }
  [[nodiscard]] std::size_t size() const { return has_room_ ? static_cast<std::size_t>(at_ - begin_) : kDoesNotFit; }

 private:
  // Asks for a field's largest size, so a payload that ends closer than that to the end counts as too large.
  bool HasRoom(std::size_t bytes) { return has_room_ = has_room_ && static_cast<std::size_t>(end_ - at_) >= bytes; }
  void Put(std::uint64_t value) {
    while (value >= 0x80) {
      *at_++ = static_cast<std::uint8_t>(value | 0x80);
      value >>= 7;
    }
    *at_++ = static_cast<std::uint8_t>(value);
  }

  std::uint8_t* at_;
  std::uint8_t* end_;
  std::uint8_t* begin_;
  bool has_room_ = true;
};

struct Field {
  std::uint32_t number = 0;
  std::uint32_t type = 0;
  std::uint64_t value = 0;  // varint, fixed64
  std::span<const std::uint8_t> bytes;

  [[nodiscard]] bool Is(std::uint32_t wanted, WireType wanted_type) const {
    return number == wanted && type == wanted_type;
  }
  [[nodiscard]] std::int64_t zigzag() const { return static_cast<std::int64_t>((value >> 1) ^ (~(value & 1) + 1)); }
};

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> in) : at_(in.data()), end_(in.data() + in.size()) {}

  // False: the end, or bytes that are no field (then is_sound() is false).
  bool Next(Field* field) {
    if (at_ == end_) return false;
    std::uint64_t tag = 0;
    is_sound_ = Get(&tag) && tag >> 3 != 0 && tag <= 0xffff'ffff;
    if (!is_sound_) return false;
    field->number = static_cast<std::uint32_t>(tag >> 3);
    field->type = static_cast<std::uint32_t>(tag & 7);
    switch (field->type) {
      case kVarint:
        is_sound_ = Get(&field->value);
        break;
      case kFixed64:
        is_sound_ = Left() >= 8;
        if (is_sound_) std::memcpy(&field->value, at_, 8);
        if (is_sound_) at_ += 8;
        break;
      case kBytes: {
        std::uint64_t size = 0;
        is_sound_ = Get(&size) && size <= Left();
        if (is_sound_) field->bytes = {at_, static_cast<std::size_t>(size)};
        if (is_sound_) at_ += size;
        break;
      }
      case kFixed32:
        is_sound_ = Left() >= 4;
        if (is_sound_) at_ += 4;
        break;
      default:
        is_sound_ = false;
    }
    return is_sound_;
  }
  [[nodiscard]] bool is_sound() const { return is_sound_; }

 private:
  [[nodiscard]] std::size_t Left() const { return static_cast<std::size_t>(end_ - at_); }
  bool Get(std::uint64_t* value) {
    *value = 0;
    for (unsigned shift = 0; shift < 70 && at_ != end_; shift += 7) {
      const std::uint8_t byte = *at_++;
      *value |= static_cast<std::uint64_t>(byte & 0x7f) << (shift & 63);
      if (byte < 0x80) return true;
    }
    return false;
  }

  const std::uint8_t* at_;
  const std::uint8_t* end_;
  bool is_sound_ = true;
};

// A repeated double, packed or not.
template <std::size_t N>
struct Doubles {
  std::array<double, N> values;
  std::size_t count = 0;
  bool is_sound = true;

  // False: the field is another one.
  bool Take(const Field& field, std::uint32_t number) {
    if (field.Is(number, kBytes)) {
      const std::size_t added = field.bytes.size() / sizeof(double);
      is_sound = is_sound && field.bytes.size() % sizeof(double) == 0 && added <= N - count;
      if (!is_sound) return true;
      std::memcpy(values.data() + count, field.bytes.data(), field.bytes.size());
      count += added;
      return true;
    }
    if (!field.Is(number, kFixed64)) return false;
    is_sound = is_sound && count < N;
    if (is_sound) values[count++] = std::bit_cast<double>(field.value);
    return true;
  }
  [[nodiscard]] bool is_complete() const { return is_sound && count == N; }
};

glm::dvec3 Vec3(const double* in) {
  return {in[0], in[1], in[2]};
}
core::Pose PoseOf(const PoseValues& in) {
  return {glm::dquat(in[0], in[1], in[2], in[3]), Vec3(&in[4])};
}
core::Twist TwistOf(const VectorValues& in) {
  return {Vec3(&in[0]), Vec3(&in[3])};
}
core::Wrench WrenchOf(const VectorValues& in) {
  return {Vec3(&in[0]), Vec3(&in[3])};
}

// As the library: a uint32 keeps the low bits of what came.
std::uint32_t Low(std::uint64_t value) {
  return static_cast<std::uint32_t>(value);
}

}  // namespace

// --- proto/device.proto

std::size_t EncodeFlat(const core::DeviceState& m, std::span<std::uint8_t> out) noexcept {
  Writer w(out);
  w.Varint(1, m.role_index);
  w.Fixed64(2, static_cast<std::uint64_t>(m.sample_ns));
  w.Doubles(3, ValuesOf(m.X_WD));
  w.Doubles(4, ValuesOf(m.V_WD));
  w.Double(5, m.opening_m);
  w.Double(6, m.opening_velocity_m_per_s);
  w.Varint(7, m.is_engaged ? 1 : 0);
  w.Varint(8, m.is_simulated ? 1 : 0);
  return w.size();
}

bool DecodeFlat(std::span<const std::uint8_t> in, core::DeviceState* m) noexcept {
  Reader reader(in);
  Field f;
  Doubles<7> X_WD;
  Doubles<6> V_WD;
  std::uint32_t role = 0;
  std::int64_t sample_ns = 0;
  double opening_m = 0.0, opening_velocity_m_per_s = 0.0;
  bool is_engaged = false, is_simulated = false;
  while (reader.Next(&f)) {
    if (X_WD.Take(f, 3) || V_WD.Take(f, 4)) continue;
    if (f.Is(1, kVarint)) role = Low(f.value);
    if (f.Is(2, kFixed64)) sample_ns = static_cast<std::int64_t>(f.value);
    if (f.Is(5, kFixed64)) opening_m = std::bit_cast<double>(f.value);
    if (f.Is(6, kFixed64)) opening_velocity_m_per_s = std::bit_cast<double>(f.value);
    if (f.Is(7, kVarint)) is_engaged = f.value != 0;
    if (f.Is(8, kVarint)) is_simulated = f.value != 0;
  }
  if (!reader.is_sound() || !X_WD.is_complete() || !V_WD.is_complete() || role > 0xff) return false;
  m->role_index = static_cast<std::uint8_t>(role);
  m->sample_ns = sample_ns;
  m->X_WD = PoseOf(X_WD.values);
  m->V_WD = TwistOf(V_WD.values);
  m->opening_m = opening_m;
  m->opening_velocity_m_per_s = opening_velocity_m_per_s;
  m->is_engaged = is_engaged;
  m->is_simulated = is_simulated;
  return true;
}

std::size_t EncodeFlat(const core::DeviceCommand& m, std::span<std::uint8_t> out) noexcept {
  Writer w(out);
  w.Varint(1, m.role_index);
  w.Doubles(2, ValuesOf(m.F_Do_W));
  w.Double(3, m.grip_force_N);
  w.Zigzag(4, m.validity_ns);
  return w.size();
}

bool DecodeFlat(std::span<const std::uint8_t> in, core::DeviceCommand* m) noexcept {
  Reader reader(in);
  Field f;
  Doubles<6> F_Do_W;
  std::uint32_t role = 0;
  double grip_force_N = 0.0;
  std::int64_t validity_ns = 0;
  while (reader.Next(&f)) {
    if (F_Do_W.Take(f, 2)) continue;
    if (f.Is(1, kVarint)) role = Low(f.value);
    if (f.Is(3, kFixed64)) grip_force_N = std::bit_cast<double>(f.value);
    if (f.Is(4, kVarint)) validity_ns = f.zigzag();
  }
  if (!reader.is_sound() || !F_Do_W.is_complete() || role > 0xff) return false;
  m->role_index = static_cast<std::uint8_t>(role);
  m->F_Do_W = WrenchOf(F_Do_W.values);
  m->grip_force_N = grip_force_N;
  m->validity_ns = validity_ns;
  return true;
}

// --- proto/haptic.proto

std::size_t EncodeFlat(const core::HapticProxy& m, std::span<std::uint8_t> out) noexcept {
  Writer w(out);
  w.Varint(1, m.role_index);
  w.Varint(2, m.cycle);
  w.Doubles(3, ValuesOf(m.X_WD));
  w.Doubles(4, ValuesOf(m.V_WD));
  w.Doubles(5, ValuesOf(m.X_WC));
  w.Double(6, m.opening_m);
  w.Varint(7, m.is_in_contact ? 1 : 0);
  w.Varint(8, m.is_engaged ? 1 : 0);
  w.Doubles(9, ValuesOf(m.F_Do_W));
  return w.size();
}

bool DecodeFlat(std::span<const std::uint8_t> in, core::HapticProxy* m) noexcept {
  Reader reader(in);
  Field f;
  Doubles<7> X_WD, X_WC;
  Doubles<6> V_WD, F_Do_W;
  std::uint32_t role = 0;
  std::uint64_t cycle = 0;
  double opening_m = 0.0;
  bool is_in_contact = false, is_engaged = false;
  while (reader.Next(&f)) {
    if (X_WD.Take(f, 3) || V_WD.Take(f, 4) || X_WC.Take(f, 5) || F_Do_W.Take(f, 9)) continue;
    if (f.Is(1, kVarint)) role = Low(f.value);
    if (f.Is(2, kVarint)) cycle = f.value;
    if (f.Is(6, kFixed64)) opening_m = std::bit_cast<double>(f.value);
    if (f.Is(7, kVarint)) is_in_contact = f.value != 0;
    if (f.Is(8, kVarint)) is_engaged = f.value != 0;
  }
  if (!reader.is_sound() || !X_WD.is_complete() || !V_WD.is_complete() || !X_WC.is_complete() ||
      !F_Do_W.is_complete() || role > 0xff) {
    return false;
  }
  m->role_index = static_cast<std::uint8_t>(role);
  m->cycle = cycle;
  m->X_WD = PoseOf(X_WD.values);
  m->V_WD = TwistOf(V_WD.values);
  m->X_WC = PoseOf(X_WC.values);
  m->opening_m = opening_m;
  m->is_in_contact = is_in_contact;
  m->is_engaged = is_engaged;
  m->F_Do_W = WrenchOf(F_Do_W.values);
  return true;
}

// --- proto/physics.proto

std::size_t EncodeFlat(const core::Reaction& m, std::span<std::uint8_t> out) noexcept {
  Writer w(out);
  w.Varint(1, m.role_index);
  w.Varint(2, m.tick);
  w.Varint(3, m.grasped_object);
  w.Doubles(4, ValuesOf(m.F_Do_W));
  return w.size();
}

bool DecodeFlat(std::span<const std::uint8_t> in, core::Reaction* m) noexcept {
  Reader reader(in);
  Field f;
  Doubles<6> F_Do_W;
  std::uint32_t role = 0, grasped_object = 0;
  std::uint64_t tick = 0;
  while (reader.Next(&f)) {
    if (F_Do_W.Take(f, 4)) continue;
    if (f.Is(1, kVarint)) role = Low(f.value);
    if (f.Is(2, kVarint)) tick = f.value;
    if (f.Is(3, kVarint)) grasped_object = Low(f.value);
  }
  if (!reader.is_sound() || !F_Do_W.is_complete() || role > 0xff || grasped_object > 0xffff) return false;
  m->role_index = static_cast<std::uint8_t>(role);
  m->tick = tick;
  m->grasped_object = static_cast<std::uint16_t>(grasped_object);
  m->F_Do_W = WrenchOf(F_Do_W.values);
  return true;
}

}  // namespace bus::detail
