// Against the library that the format is from.

#include "bus/detail/flat_codec.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "bus/codec.hpp"
#include "proto/device.pb.h"
#include "proto/haptic.pb.h"
#include "proto/logic.pb.h"
#include "proto/physics.pb.h"

namespace bus::detail {
namespace {

class Values {
 public:
  // Often zero, sometimes minus zero: what proto3 leaves out, and what it does not.
  double Double() {
    const std::uint64_t kind = random_() % 6;
    return kind == 0 ? 0.0 : kind == 1 ? -0.0 : static_cast<double>(static_cast<std::int64_t>(random_())) * 1e-17;
  }
  std::uint64_t Whole() { return random_() % 3 == 0 ? 0 : random_() >> (random_() % 64); }
  bool Bool() { return random_() % 2 == 0; }
  glm::dvec3 Vec() { return {Double(), Double(), Double()}; }
  core::Pose Pose() { return {glm::dquat(Double(), Double(), Double(), Double()), Vec()}; }
  std::mt19937_64 random_{11};
};

template <class List>
void Add(List* list, const glm::dvec3& a, const glm::dvec3& b) {
  for (const glm::dvec3& v : {a, b}) {
    for (int i = 0; i < 3; ++i) list->Add(v[i]);
  }
}
template <class List>
void Add(List* list, const core::Pose& X) {
  for (const double v : {X.rotation.w, X.rotation.x, X.rotation.y, X.rotation.z}) list->Add(v);
  for (int i = 0; i < 3; ++i) list->Add(X.translation[i]);
}

core::DeviceState Fill(Values& v, oos::DeviceState* p) {
  core::DeviceState m;
  m.role_index = static_cast<std::uint8_t>(v.Whole());
  m.sample_ns = static_cast<std::int64_t>(v.Whole());
  m.X_WD = v.Pose();
  m.V_WD = {v.Vec(), v.Vec()};
  m.opening_m = v.Double();
  m.opening_velocity_m_per_s = v.Double();
  m.is_engaged = v.Bool();
  m.is_simulated = v.Bool();
  p->set_role_index(m.role_index);
  p->set_sample_ns(m.sample_ns);
  Add(p->mutable_x_wd(), m.X_WD);
  Add(p->mutable_v_wd(), m.V_WD.angular_rad_per_s, m.V_WD.linear_m_per_s);
  p->set_opening_m(m.opening_m);
  p->set_opening_velocity_m_per_s(m.opening_velocity_m_per_s);
  p->set_is_engaged(m.is_engaged);
  p->set_is_simulated(m.is_simulated);
  return m;
}

core::DeviceCommand Fill(Values& v, oos::DeviceCommand* p) {
  core::DeviceCommand m;
  m.role_index = static_cast<std::uint8_t>(v.Whole());
  m.F_Do_W = {v.Vec(), v.Vec()};
  m.grip_force_N = v.Double();
  m.validity_ns = static_cast<std::int64_t>(v.Whole()) * (v.Bool() ? 1 : -1);
  p->set_role_index(m.role_index);
  Add(p->mutable_f_do_w(), m.F_Do_W.force_N, m.F_Do_W.torque_Nm);
  p->set_grip_force_n(m.grip_force_N);
  p->set_validity_ns(m.validity_ns);
  return m;
}

core::HapticProxy Fill(Values& v, oos::HapticProxy* p) {
  core::HapticProxy m;
  m.role_index = static_cast<std::uint8_t>(v.Whole());
  m.cycle = v.Whole();
  m.X_WD = v.Pose();
  m.V_WD = {v.Vec(), v.Vec()};
  m.X_WC = v.Pose();
  m.opening_m = v.Double();
  m.is_in_contact = v.Bool();
  m.is_engaged = v.Bool();
  m.F_Do_W = {v.Vec(), v.Vec()};
  p->set_role_index(m.role_index);
  p->set_cycle(m.cycle);
  Add(p->mutable_x_wd(), m.X_WD);
  Add(p->mutable_v_wd(), m.V_WD.angular_rad_per_s, m.V_WD.linear_m_per_s);
  Add(p->mutable_x_wc(), m.X_WC);
  p->set_opening_m(m.opening_m);
  p->set_is_in_contact(m.is_in_contact);
  p->set_is_engaged(m.is_engaged);
  Add(p->mutable_f_do_w(), m.F_Do_W.force_N, m.F_Do_W.torque_Nm);
  return m;
}

core::Reaction Fill(Values& v, oos::Reaction* p) {
  core::Reaction m;
  m.role_index = static_cast<std::uint8_t>(v.Whole());
  m.tick = v.Whole();
  m.grasped_object = static_cast<std::uint16_t>(v.Whole());
  m.F_Do_W = {v.Vec(), v.Vec()};
  p->set_role_index(m.role_index);
  p->set_tick(m.tick);
  p->set_grasped_object(m.grasped_object);
  Add(p->mutable_f_do_w(), m.F_Do_W.force_N, m.F_Do_W.torque_Nm);
  return m;
}

template <class M>
std::string Encode(const M& message) {
  std::string bytes(600, '\0');
  bytes.resize(EncodeFlat(message, {reinterpret_cast<std::uint8_t*>(bytes.data()), bytes.size()}));
  return bytes;
}
template <class M>
bool Decode(const std::string& bytes, M* message) {
  return DecodeFlat({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, message);
}

template <class Pair>
class FlatCodec : public testing::Test {};
template <class M, class P>
struct Of {
  using Core = M;
  using Proto = P;
};
using All = testing::Types<Of<core::DeviceState, oos::DeviceState>, Of<core::DeviceCommand, oos::DeviceCommand>,
                           Of<core::HapticProxy, oos::HapticProxy>, Of<core::Reaction, oos::Reaction>>;
TYPED_TEST_SUITE(FlatCodec, All);

TYPED_TEST(FlatCodec, WritesWhatTheLibraryWritesAndReadsItBack) {
  Values values;
  for (int round = 0; round < 5'000; ++round) {
    typename TypeParam::Proto proto;
    const auto message = Fill(values, &proto);
    const std::string bytes = Encode(message);
    ASSERT_EQ(bytes, proto.SerializeAsString());
    typename TypeParam::Core read;
    ASSERT_TRUE(Decode(bytes, &read));
    ASSERT_EQ(Encode(read), bytes);
  }
}

// Damaged bytes: what the library reads and finds complete is read the same, everything else is refused.
TYPED_TEST(FlatCodec, AgreesWithTheLibraryOnDamagedBytes) {
  Values values;
  auto& random = values.random_;
  int taken = 0;
  for (int round = 0; round < 100'000; ++round) {
    typename TypeParam::Proto proto;
    Fill(values, &proto);
    std::string bytes = proto.SerializeAsString();
    for (std::uint64_t i = random() % 4; i > 0; --i) bytes[random() % bytes.size()] = static_cast<char>(random());
    if (random() % 4 == 0) bytes.resize(random() % (bytes.size() + 1));
    if (random() % 8 == 0) bytes += std::string("\x9a\x06\x03", 3) + "new";  // a field of a later version
    typename TypeParam::Core read;
    typename TypeParam::Proto again;
    const bool is_taken = Decode(bytes, &read);
    taken += is_taken ? 1 : 0;
    if (!again.ParseFromString(bytes)) {
      ASSERT_FALSE(is_taken);
      continue;
    }
    if (!is_taken) continue;  // arrays incomplete, or out of range
    again.DiscardUnknownFields();
    ASSERT_EQ(Encode(read), again.SerializeAsString());
  }
  EXPECT_GT(taken, 10'000);
}

TYPED_TEST(FlatCodec, RefusesTooLittleRoom) {
  Values values;
  typename TypeParam::Proto proto;
  const auto message = Fill(values, &proto);
  const std::size_t size = Encode(message).size();
  std::string room(size, '\0');
  for (std::size_t less = 0; less < size; ++less) {
    ASSERT_EQ(EncodeFlat(message, {reinterpret_cast<std::uint8_t*>(room.data()), less}), kDoesNotFit);
  }
}

TEST(FiguresCodec, WritesWhatTheLibraryWrites) {
  for (const std::size_t count : {0, 1, 13, 40}) {
    Figures figures;
    oos::Figures proto;
    for (std::size_t i = 0; i < count; ++i) {
      figures.items.push_back({std::string(i * 7, 'n'), static_cast<double>(i) * 0.5});
      proto.add_name(figures.items.back().name);
      proto.add_value(figures.items.back().value);
    }
    std::string bytes = "old";
    EncodeState(figures, &bytes);
    EXPECT_EQ(bytes, proto.SerializeAsString());
  }
}

}  // namespace
}  // namespace bus::detail
