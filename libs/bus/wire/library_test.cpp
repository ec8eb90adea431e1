// The codec against protobuf's library, the reference of the format.

#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

#include "bus/wire/codec.hpp"
#include "bus/wire/envelope.hpp"
#include "bus/wire/wire.hpp"
#include "proto/bulk.pb.h"
#include "proto/camera.pb.h"
#include "proto/device.pb.h"
#include "proto/haptic.pb.h"
#include "proto/logic.pb.h"
#include "proto/physics.pb.h"
#include "proto/viewing.pb.h"

namespace bus {
namespace {

class Values {
 public:
  // Often zero, which proto3 leaves out, and sometimes minus zero, which it does not.
  double Double() {
    const std::uint64_t kind = random_() % 6;
    return kind == 0 ? 0.0 : kind == 1 ? -0.0 : static_cast<double>(static_cast<std::int64_t>(random_())) * 1e-17;
  }
  std::uint64_t Whole() { return random_() % 3 == 0 ? 0 : random_() >> (random_() % 64); }
  float Float() { return static_cast<float>(Double()); }
  bool Bool() { return random_() % 2 == 0; }
  glm::vec3 Vecf() { return {Float(), Float(), Float()}; }
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
  m.J_contact_Wo_W = {v.Vec(), v.Vec()};
  p->set_role_index(m.role_index);
  p->set_sample_ns(m.sample_ns);
  Add(p->mutable_x_wd(), m.X_WD);
  Add(p->mutable_v_wd(), m.V_WD.angular_rad_per_s, m.V_WD.linear_m_per_s);
  p->set_opening_m(m.opening_m);
  p->set_opening_velocity_m_per_s(m.opening_velocity_m_per_s);
  p->set_is_engaged(m.is_engaged);
  p->set_is_simulated(m.is_simulated);
  Add(p->mutable_j_contact_wo_w(), m.J_contact_Wo_W.force_N, m.J_contact_Wo_W.torque_Nm);
  return m;
}

core::DeviceCommand Fill(Values& v, oos::DeviceCommand* p) {
  core::DeviceCommand m;
  m.role_index = static_cast<std::uint8_t>(v.Whole());
  m.F_Do_W = {v.Vec(), v.Vec()};
  m.grip_force_N = v.Double();
  m.validity_ns = static_cast<std::int64_t>(v.Whole()) * (v.Bool() ? 1 : -1);
  m.has_field = v.Bool();
  m.X_WD = v.Pose();
  m.X_WC = v.Pose();
  m.p_CoCm_C = v.Vec();
  m.stiffness_N_per_m = v.Double();
  m.stiffness_Nm_per_rad = v.Double();
  m.F_rest_Do_W = {v.Vec(), v.Vec()};
  m.force_cap_N = v.Double();
  m.gain = v.Double();
  for (std::uint64_t i = v.random_() % 5; i > 0; --i) {  // as many as go into one datagram
    m.contacts.push_back(
        {v.Vecf(), v.Vecf(), v.Vecf(), v.Vecf(), v.Float(), v.Float(), v.Float(), v.Float(), v.Vecf()});
  }
  p->set_role_index(m.role_index);
  Add(p->mutable_f_do_w(), m.F_Do_W.force_N, m.F_Do_W.torque_Nm);
  p->set_grip_force_n(m.grip_force_N);
  p->set_validity_ns(m.validity_ns);
  p->set_has_field(m.has_field);
  Add(p->mutable_x_wd(), m.X_WD);
  Add(p->mutable_x_wc(), m.X_WC);
  for (int i = 0; i < 3; ++i) p->add_p_cocm_c(m.p_CoCm_C[i]);
  p->set_stiffness_n_per_m(m.stiffness_N_per_m);
  p->set_stiffness_nm_per_rad(m.stiffness_Nm_per_rad);
  Add(p->mutable_f_rest_do_w(), m.F_rest_Do_W.force_N, m.F_rest_Do_W.torque_Nm);
  p->set_force_cap_n(m.force_cap_N);
  p->set_gain(m.gain);
  p->set_num_contacts(static_cast<std::uint32_t>(m.contacts.size()));
  for (const core::FieldContact& c : m.contacts) {
    for (int i = 0; i < 3; ++i) {
      p->add_p_c_w(c.p_C_W[i]);
      p->add_n_w(c.n_W[i]);
      p->add_v_w(c.v_W[i]);
      p->add_slip_w(c.slip_W[i]);
      p->add_tangent_w_n(c.tangent_W_N[i]);
    }
    p->add_gap_m(c.gap_m);
    p->add_friction(c.friction);
    p->add_most_n(c.most_N);
    p->add_normal_n(c.normal_N);
  }
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
  m.J_contact_Wo_W = {v.Vec(), v.Vec()};
  p->set_role_index(m.role_index);
  p->set_tick(m.tick);
  p->set_grasped_object(m.grasped_object);
  Add(p->mutable_f_do_w(), m.F_Do_W.force_N, m.F_Do_W.torque_Nm);
  Add(p->mutable_j_contact_wo_w(), m.J_contact_Wo_W.force_N, m.J_contact_Wo_W.torque_Nm);
  return m;
}

// --- Messages in parts, split field by field at the bounds of the first release.

using Doubles = google::protobuf::RepeatedField<double>;
using Floats = google::protobuf::RepeatedField<float>;

void Append(const core::Pose& X, Doubles* out) {
  for (const double v :
       {X.rotation.w, X.rotation.x, X.rotation.y, X.rotation.z, X.translation.x, X.translation.y, X.translation.z}) {
    out->Add(v);
  }
}
void Append(const core::Twist& V, Doubles* out) {
  for (const glm::dvec3& v : {V.angular_rad_per_s, V.linear_m_per_s}) {
    for (int i = 0; i < 3; ++i) out->Add(v[i]);
  }
}
void Append(const core::Wrench& F, Doubles* out) {
  for (const glm::dvec3& v : {F.force_N, F.torque_Nm}) {
    for (int i = 0; i < 3; ++i) out->Add(v[i]);
  }
}
void Append(const glm::vec3& v, Floats* out) {
  for (int i = 0; i < 3; ++i) out->Add(v[i]);
}

constexpr int kPoseSize = 7, kTwistSize = 6;
// Upper bounds of encoded sizes [bytes]: what a part holds besides its items, and one item. A double in a packed array
// takes 8, a float or fixed32 4, an index up to 65535 3, a tag with its length 3.
constexpr std::size_t kStateScalarBytes = 69;
constexpr std::size_t kBodyBytes = 3 + 8 * (kPoseSize + kTwistSize);
constexpr std::size_t kMechanismBytes = 3 + 5 + 8 + 8;
constexpr std::size_t kContactScalarBytes = 125;
constexpr std::size_t kPlaneBytes = 4 + 4 * 10;
constexpr std::size_t kSheetScalarBytes = 40;
constexpr std::size_t kNodeBytes = 4 * 3;

struct FieldRange {
  std::size_t first = 0, count = 0;
};

// Part k of a state: mechanisms first, then bodies, each part filled up to the budget.
struct StatePart {
  FieldRange mechanisms, bodies;
};

StatePart PartOf(const core::PhysicsState& state, int part, std::size_t budget, bool* is_last) {
  const std::size_t room = budget > kStateScalarBytes + kBodyBytes ? budget - kStateScalarBytes : kBodyBytes;
  StatePart range;
  for (int k = 0;; ++k) {
    range.mechanisms = {range.mechanisms.first + range.mechanisms.count, 0};
    range.bodies = {range.bodies.first + range.bodies.count, 0};
    std::size_t left = room;
    range.mechanisms.count = std::min(state.mechanisms.size() - range.mechanisms.first, left / kMechanismBytes);
    left -= range.mechanisms.count * kMechanismBytes;
    range.bodies.count = std::min(state.bodies.size() - range.bodies.first, left / kBodyBytes);
    *is_last = range.mechanisms.first + range.mechanisms.count == state.mechanisms.size() &&
               range.bodies.first + range.bodies.count == state.bodies.size();
    if (k == part || *is_last) return range;
  }
}

std::size_t PlanesPerPart(std::size_t budget) {
  const std::size_t room = budget > kContactScalarBytes ? budget - kContactScalarBytes : 0;
  return std::max<std::size_t>(room / kPlaneBytes, 1);
}

std::size_t NodesPerPart(std::size_t budget) {
  const std::size_t room = budget > kSheetScalarBytes ? budget - kSheetScalarBytes : 0;
  return std::max<std::size_t>(room / kNodeBytes, 1);
}

void FillPart(const core::ContactSet& m, int part, std::size_t budget, oos::ContactSet* p) {
  p->set_pair_index(m.pair_index);
  p->set_sampled_body(m.sampled_body);
  p->set_field_body(m.field_body);
  p->set_cycle(m.cycle);
  p->set_signed_distance_m(m.signed_distance_m);
  p->set_is_in_contact(m.is_in_contact);
  Append(m.F_So_W, p->mutable_f_so_w());
  p->set_damping_n_s_per_m(m.damping_N_s_per_m);
  p->set_friction(m.friction);
  const std::size_t per_part = PlanesPerPart(budget);
  const std::size_t first = std::min(static_cast<std::size_t>(part) * per_part, m.planes.size());
  const std::size_t last = std::min(first + per_part, m.planes.size());
  p->set_num_planes(static_cast<std::uint32_t>(m.planes.size()));
  p->set_first_plane(static_cast<std::uint32_t>(first));
  for (std::size_t i = first; i < last; ++i) {
    const core::ContactPlane& plane = m.planes[i];
    p->add_id(plane.id);
    Append(plane.p_S, p->mutable_p_s());
    Append(plane.q_G, p->mutable_q_g());
    Append(plane.n_G, p->mutable_n_g());
    p->add_stiffness_n_per_m(plane.stiffness_N_per_m);
  }
}

void FillPart(const core::PhysicsState& m, int part, std::size_t budget, oos::PhysicsState* p) {
  bool is_last = false;
  const StatePart range = PartOf(m, part, budget, &is_last);
  p->set_tick(m.tick);
  p->set_time_ns(m.time_ns);
  p->set_is_in_contact(m.is_in_contact);
  p->set_state_hash(m.state_hash);
  p->set_num_bodies(static_cast<std::uint32_t>(m.bodies.size()));
  p->set_first_body(static_cast<std::uint32_t>(range.bodies.first));
  for (std::size_t i = range.bodies.first; i < range.bodies.first + range.bodies.count; ++i) {
    p->add_object(m.bodies[i].object);
    Append(m.bodies[i].X_WO, p->mutable_x_wo());
    Append(m.bodies[i].V_WO, p->mutable_v_wo());
  }
  p->set_num_mechanisms(static_cast<std::uint32_t>(m.mechanisms.size()));
  p->set_first_mechanism(static_cast<std::uint32_t>(range.mechanisms.first));
  for (std::size_t i = range.mechanisms.first; i < range.mechanisms.first + range.mechanisms.count; ++i) {
    const core::MechanismState& mechanism = m.mechanisms[i];
    p->add_mechanism(mechanism.mechanism);
    p->add_state(mechanism.state);
    p->add_position(mechanism.position);
    p->add_force(mechanism.force);
  }
}

void FillPart(const core::SheetState& m, int part, std::size_t budget, oos::SheetState* p) {
  p->set_object(m.object);
  p->set_tick(m.tick);
  p->set_num_columns(m.num_columns);
  const std::size_t per_part = NodesPerPart(budget);
  const std::size_t first = std::min(static_cast<std::size_t>(part) * per_part, m.p_W.size());
  const std::size_t last = std::min(first + per_part, m.p_W.size());
  p->set_num_nodes(static_cast<std::uint32_t>(m.p_W.size()));
  p->set_first_node(static_cast<std::uint32_t>(first));
  for (std::size_t i = first; i < last; ++i) Append(m.p_W[i], p->mutable_p_w());
}

core::ContactSet Fill(Values& v, oos::ContactSet* p) {
  core::ContactSet m;
  m.pair_index = static_cast<std::uint16_t>(v.Whole());
  m.sampled_body = static_cast<std::uint16_t>(v.Whole());
  m.field_body = static_cast<std::uint16_t>(v.Whole());
  m.cycle = v.Whole();
  m.signed_distance_m = v.Double();
  m.is_in_contact = v.Bool();
  m.F_So_W = {v.Vec(), v.Vec()};
  m.damping_N_s_per_m = v.Float();
  m.friction = v.Float();
  for (std::uint64_t i = v.random_() % (core::kMaxContactPlanes + 1); i > 0; --i) {
    m.planes.push_back({static_cast<std::uint32_t>(v.Whole()), v.Vecf(), v.Vecf(), v.Vecf(), v.Float()});
  }
  FillPart(m, 0, kMaxDatagramBytes, p);
  return m;
}

core::PhysicsState Fill(Values& v, oos::PhysicsState* p) {
  core::PhysicsState m;
  m.tick = v.Whole();
  m.time_ns = static_cast<std::int64_t>(v.Whole()) * (v.Bool() ? 1 : -1);
  m.is_in_contact = v.Bool();
  m.state_hash = v.Whole();
  for (std::uint64_t i = v.random_() % (v.Bool() ? 4 : core::kMaxBodies + 1); i > 0; --i) {
    m.bodies.push_back({static_cast<std::uint16_t>(v.Whole()), v.Pose(), {v.Vec(), v.Vec()}});
  }
  for (std::uint64_t i = v.random_() % (v.Bool() ? 4 : core::kMaxMechanisms + 1); i > 0; --i) {
    m.mechanisms.push_back(
        {static_cast<std::uint16_t>(v.Whole()), static_cast<std::int32_t>(v.Whole()), v.Double(), v.Double()});
  }
  FillPart(m, 0, kMaxDatagramBytes, p);
  return m;
}

core::SheetState Fill(Values& v, oos::SheetState* p) {
  core::SheetState m;
  m.object = static_cast<std::uint16_t>(v.Whole());
  m.tick = v.Whole();
  m.num_columns = static_cast<std::uint16_t>(v.random_() % 8);
  for (std::uint64_t i = m.num_columns * (v.random_() % 100); i > 0; --i) m.p_W.push_back(v.Vecf());
  FillPart(m, 0, kMaxDatagramBytes, p);
  return m;
}

template <class M>
std::string Encode(const M& message) {
  std::string bytes(kMaxDatagramBytes, '\0');
  bytes.resize(LatestCodec<M>().Encode(message, 0, kMaxDatagramBytes, reinterpret_cast<std::uint8_t*>(bytes.data()),
                                       bytes.size()));
  return bytes;
}
template <class M>
bool Decode(const std::string& bytes, M* message) {
  return LatestCodec<M>().Decode({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, true, message);
}

template <class Pair>
class LibraryTest : public ::testing::Test {};
template <class M, class P>
struct Of {
  using Core = M;
  using Proto = P;
};
using All = ::testing::Types<Of<core::DeviceState, oos::DeviceState>, Of<core::DeviceCommand, oos::DeviceCommand>,
                             Of<core::HapticProxy, oos::HapticProxy>, Of<core::Reaction, oos::Reaction>,
                             Of<core::ContactSet, oos::ContactSet>, Of<core::PhysicsState, oos::PhysicsState>,
                             Of<core::SheetState, oos::SheetState>>;
TYPED_TEST_SUITE(LibraryTest, All);

// Whether this is the whole message, so that what is read can be written again as it was.
template <class P>
bool IsWhole(const P& p) {
  if constexpr (requires { p.num_planes(); }) return p.num_planes() == static_cast<std::uint32_t>(p.id_size());
  if constexpr (requires { p.num_contacts(); }) {
    return p.num_contacts() == static_cast<std::uint32_t>(p.gap_m_size());
  }
  if constexpr (requires { p.num_bodies(); }) {
    return p.num_bodies() == static_cast<std::uint32_t>(p.object_size()) &&
           p.num_mechanisms() == static_cast<std::uint32_t>(p.mechanism_size());
  }
  if constexpr (requires { p.num_finger_joints(); }) {
    return p.num_finger_joints() == static_cast<std::uint32_t>(p.finger_rad_size());
  }
  if constexpr (requires { p.num_nodes(); }) return 3 * p.num_nodes() == static_cast<std::uint32_t>(p.p_w_size());
  return true;
}

// What writers of before do not send, as the codec reads it.
template <class P>
void AddWhatMayLack(P* p) {
  const auto add = [](google::protobuf::RepeatedField<double>* numbers, std::initializer_list<double> initial) {
    if (numbers->empty()) numbers->Add(initial.begin(), initial.end());
  };
  if constexpr (requires { p->j_contact_wo_w(); }) add(p->mutable_j_contact_wo_w(), {0, 0, 0, 0, 0, 0});
  if constexpr (requires { p->f_rest_do_w(); }) {
    add(p->mutable_x_wd(), {1, 0, 0, 0, 0, 0, 0});
    add(p->mutable_x_wc(), {1, 0, 0, 0, 0, 0, 0});
    add(p->mutable_p_cocm_c(), {0, 0, 0});
    add(p->mutable_f_rest_do_w(), {0, 0, 0, 0, 0, 0});
  }
}

TYPED_TEST(LibraryTest, WritesTheSameBytesAndReadsThemBack) {
  Values values;
  for (int round = 0; round < 5'000; ++round) {
    typename TypeParam::Proto proto;
    const auto message = Fill(values, &proto);
    const std::string bytes = Encode(message);
    ASSERT_EQ(bytes, proto.SerializeAsString());
    typename TypeParam::Core read;
    ASSERT_TRUE(Decode(bytes, &read));
    if (!IsWhole(proto)) continue;
    ASSERT_EQ(Encode(read), bytes);
  }
}

// Damaged bytes: those that the library accepts as complete give the same message, all others are refused.
TYPED_TEST(LibraryTest, AgreesOnDamagedBytes) {
  Values values;
  auto& random = values.random_;
  int taken = 0;
  for (int round = 0; round < 100'000; ++round) {
    typename TypeParam::Proto proto;
    Fill(values, &proto);
    std::string bytes = proto.SerializeAsString();
    for (std::uint64_t i = random() % 4; i > 0 && !bytes.empty(); --i) {
      bytes[random() % bytes.size()] = static_cast<char>(random());
    }
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
    if (!is_taken || !IsWhole(again)) continue;  // arrays incomplete, or out of range
    again.DiscardUnknownFields();
    AddWhatMayLack(&again);
    ASSERT_EQ(Encode(read), again.SerializeAsString());
  }
  EXPECT_GT(taken, 10'000);
}

TYPED_TEST(LibraryTest, RefusesTooLittleRoom) {
  Values values;
  typename TypeParam::Proto proto;
  const auto message = Fill(values, &proto);
  const std::size_t size = Encode(message).size();
  std::string room(size, '\0');
  for (std::size_t less = 0; less < size; ++less) {
    ASSERT_EQ(LatestCodec<typename TypeParam::Core>().Encode(message, 0, kMaxDatagramBytes,
                                                             reinterpret_cast<std::uint8_t*>(room.data()), less),
              kDoesNotFit);
  }
}

template <class P, class M>
void ExpectSameParts(const M& message, std::size_t budget) {
  const LatestCodec<M> codec;
  const int parts = codec.NumParts(message, budget);
  for (int part = 0; part < parts; ++part) {
    P proto;
    FillPart(message, part, budget, &proto);
    std::string bytes(2 * kMaxDatagramBytes, '\0');
    bytes.resize(codec.Encode(message, part, budget, reinterpret_cast<std::uint8_t*>(bytes.data()), bytes.size()));
    ASSERT_EQ(bytes, proto.SerializeAsString()) << part << " of " << parts << ", " << budget << " bytes";
  }
}

TEST(Library, MessagesAreSplitAsInTheFirstRelease) {
  Values values;
  for (int round = 0; round < 2'000; ++round) {
    const std::size_t budget = 30 + values.random_() % 1'200;
    oos::ContactSet contacts;
    ExpectSameParts<oos::ContactSet>(Fill(values, &contacts), budget);
    oos::PhysicsState state;
    ExpectSameParts<oos::PhysicsState>(Fill(values, &state), budget);
    oos::SheetState sheet;
    ExpectSameParts<oos::SheetState>(Fill(values, &sheet), budget);
  }
}

// The library splits arrays in two, and writes them number by number, where a .proto file requires it.
template <class P, class M>
void ExpectReadsEveryForm(const M& message) {
  const std::string bytes = Encode(message);
  P proto;
  ASSERT_TRUE(proto.ParseFromString(bytes));
  std::string loose;
  detail::WireReader reader({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  for (detail::WireField field; reader.Next(&field);) {
    const google::protobuf::FieldDescriptor& described =
        *P::descriptor()->FindFieldByNumber(static_cast<int>(field.number));
    std::vector<std::uint8_t> out(2 * bytes.size() + 20);
    detail::WireWriter writer(out.data());
    const auto end = [&] { return static_cast<std::size_t>(writer.end() - out.data()); };
    if (field.type != detail::kBytes) {
      writer.Tag(field.number, static_cast<detail::WireType>(field.type));
      if (field.type == detail::kVarint) writer.Varint(field.value);
      if (field.type == detail::kFixed64) writer.Copy(field.value);
      if (field.type == detail::kFixed32) writer.Copy(static_cast<std::uint32_t>(field.value));
    } else if (described.cpp_type() == google::protobuf::FieldDescriptor::CPPTYPE_DOUBLE) {  // one loose, then packed
      writer.Tag(field.number, detail::kFixed64);
      for (int i = 0; i < 8; ++i) writer.Copy(field.bytes[static_cast<std::size_t>(i)]);
      writer.Text(field.number, {reinterpret_cast<const char*>(field.bytes.data()) + 8, field.bytes.size() - 8});
    } else if (described.cpp_type() == google::protobuf::FieldDescriptor::CPPTYPE_FLOAT) {
      writer.Tag(field.number, detail::kFixed32);
      for (int i = 0; i < 4; ++i) writer.Copy(field.bytes[static_cast<std::size_t>(i)]);
      writer.Text(field.number, {reinterpret_cast<const char*>(field.bytes.data()) + 4, field.bytes.size() - 4});
    } else {
      writer.Text(field.number, {reinterpret_cast<const char*>(field.bytes.data()), field.bytes.size()});
    }
    loose.append(reinterpret_cast<const char*>(out.data()), end());
  }
  P again;
  ASSERT_TRUE(again.ParseFromString(loose));
  ASSERT_EQ(again.SerializeAsString(), bytes);
  M read;
  ASSERT_TRUE(Decode(loose, &read));
  ASSERT_EQ(Encode(read), bytes);
}

TEST(Library, ArraysAreReadPackedLooseAndInPieces) {
  Values values;
  for (int round = 0; round < 200; ++round) {
    oos::DeviceState device;
    ExpectReadsEveryForm<oos::DeviceState>(Fill(values, &device));
    oos::PhysicsState state;
    core::PhysicsState message = Fill(values, &state);
    message.bodies.resize(std::min<std::size_t>(message.bodies.size(), 5));
    message.mechanisms.resize(std::min<std::size_t>(message.mechanisms.size(), 5));
    ExpectReadsEveryForm<oos::PhysicsState>(message);
    oos::ContactSet contacts;
    ExpectReadsEveryForm<oos::ContactSet>(Fill(values, &contacts));
  }
}

TEST(Library, FiguresAreTheSameBytes) {
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

// Reading and writing random bytes of a message P gives the same with the codec as with protobuf's library.
template <class P, class M>
void ExpectAgreement(const P& sound) {
  std::mt19937_64 random{5};
  int taken = 0;
  for (int round = 0; round < 50'000; ++round) {
    std::string bytes = sound.SerializeAsString();
    for (std::uint64_t i = random() % 4; i > 0; --i) bytes[random() % bytes.size()] = static_cast<char>(random());
    M value;
    P proto;
    const bool is_taken = DecodeState(bytes, &value);
    if (!proto.ParseFromString(bytes)) {
      ASSERT_FALSE(is_taken);
      continue;
    }
    if (!is_taken) continue;  // out of range
    ++taken;
    proto.DiscardUnknownFields();
    std::string written;
    EncodeState(value, &written);
    ASSERT_EQ(written, proto.SerializeAsString());
  }
  EXPECT_GT(taken, 5'000);
}

TEST(Library, StatesAndEventsAreReadAndWrittenAlike) {
  google::protobuf::LogSilencer silencer;  // of texts that are not UTF-8
  oos::LogicStatus status;
  status.set_time_ns(-4);
  status.set_step("switch_off");
  status.set_hint("dreh den Schalter \xc3\xbc\xe2\x82\xac\xf0\x9f\x98\x80");
  for (const char* name : {"run", "", "switch_off"}) status.add_active_states(name);
  for (const std::uint32_t object : {7u, 0u, 300u}) {
    oos::Lamp* lamp = status.add_lamps();
    lamp->set_object(object);
    lamp->set_green(0.5f);
  }
  status.set_is_failed(true);
  ExpectAgreement<oos::LogicStatus, core::LogicStatus>(status);
  oos::Figures figures;
  for (const char* name : {"step_p50_us", "misses", ""}) {
    figures.add_name(name);
    figures.add_value(1.5);
  }
  ExpectAgreement<oos::Figures, core::Figures>(figures);
  oos::BulkOffer offer;
  offer.set_name("scenario/scenario.xml");
  offer.set_hash("00ff");
  offer.set_size(70'000);
  offer.set_endpoint("tcp://127.0.0.1:4000");
  ExpectAgreement<oos::BulkOffer, core::BulkOffer>(offer);
  oos::Event event;
  event.set_time_ns(42);
  event.set_source("logic_node");
  event.set_name("step");
  event.set_detail("\xe2\x82\xac");
  ExpectAgreement<oos::Event, core::Event>(event);
  oos::ParameterChange change;
  change.set_name("latch_a.release_force_N");
  change.set_value(2.5);
  change.set_manner(1);
  change.set_ramp_s(0.5);
  ExpectAgreement<oos::ParameterChange, core::ParameterChange>(change);
}

TEST(Library, TextsAreUtf8ByTheSameRule) {
  google::protobuf::LogSilencer silencer;
  std::mt19937_64 random{9};
  const std::string leads = "\x7f\x80\xbf\xc1\xc2\xdf\xe0\xed\xef\xf0\xf4\xf5\xff";
  int sound = 0;
  for (int round = 0; round < 200'000; ++round) {
    std::string text;
    for (std::uint64_t i = random() % 4 + 1; i > 0; --i) {
      text += random() % 2 == 0 ? leads[random() % leads.size()] : static_cast<char>(0x80 + random() % 0x40);
    }
    std::string bytes = "\x12";
    bytes += static_cast<char>(text.size());
    bytes += text;
    oos::Event event;
    const bool is_sound = event.ParseFromString(bytes);
    sound += is_sound ? 1 : 0;
    ASSERT_EQ(detail::IsUtf8(text), is_sound) << bytes;
  }
  EXPECT_GT(sound, 1'000);
}

}  // namespace
}  // namespace bus
