#include "bus/codec.hpp"

#include <algorithm>

#include "bus/detail/flat_codec.hpp"
#include "bus/envelope.hpp"
#include "proto/haptic.pb.h"
#include "proto/logic.pb.h"
#include "proto/physics.pb.h"

namespace bus {
namespace {

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

glm::dvec3 Vec3(const Doubles& in, int at) {
  return {in[at], in[at + 1], in[at + 2]};
}
glm::vec3 Vec3(const Floats& in, int at) {
  return {in[at], in[at + 1], in[at + 2]};
}
core::Pose GetPose(const Doubles& in, int at) {
  return {glm::dquat(in[at], in[at + 1], in[at + 2], in[at + 3]), Vec3(in, at + 4)};
}
core::Twist GetTwist(const Doubles& in, int at) {
  return {Vec3(in, at), Vec3(in, at + 3)};
}
core::Wrench GetWrench(const Doubles& in, int at) {
  return {Vec3(in, at), Vec3(in, at + 3)};
}

constexpr int kPoseSize = 7, kTwistSize = 6, kWrenchSize = 6;
constexpr std::uint32_t kMaxIndex = 0xffff;

// Upper bounds of encoded sizes [bytes]: what a part holds besides its items, and one item. A double in a packed array
// takes 8, a float or fixed32 4, an index up to 65535 3, a tag with its length 3.
constexpr std::size_t kStateScalarBytes = 69;
constexpr std::size_t kBodyBytes = 3 + 8 * (kPoseSize + kTwistSize);
constexpr std::size_t kMechanismBytes = 3 + 5 + 8 + 8;
constexpr std::size_t kContactScalarBytes = 125;
constexpr std::size_t kPlaneBytes = 4 + 4 * 10;
constexpr std::size_t kSheetScalarBytes = 40;
constexpr std::size_t kNodeBytes = 4 * 3;

struct Range {
  std::size_t first = 0, count = 0;
};

// Part k of a state: mechanisms first, then bodies, each part filled up to the budget.
struct StatePart {
  Range mechanisms, bodies;
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

// --- core -> protobuf. `part` and `budget` matter only for messages that may be split.

void Fill(const core::ContactSet& m, int part, std::size_t budget, oos::ContactSet* p) {
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

void Fill(const core::PhysicsState& m, int part, std::size_t budget, oos::PhysicsState* p) {
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

void Fill(const core::SheetState& m, int part, std::size_t budget, oos::SheetState* p) {
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

// --- protobuf -> core. Everything is checked before anything is written.

// A part's items must lie inside the list whose whole size it tells.
bool IsRangeSound(std::uint64_t first, int count, std::uint64_t total, std::size_t capacity) {
  return total <= capacity && first + static_cast<std::uint64_t>(count) <= total;
}

bool Take(const oos::ContactSet& p, bool is_first, core::ContactSet* m) {
  const int n = p.id_size();
  if (p.f_so_w_size() != kWrenchSize || p.p_s_size() != 3 * n || p.q_g_size() != 3 * n || p.n_g_size() != 3 * n ||
      p.stiffness_n_per_m_size() != n || p.pair_index() > kMaxIndex || p.sampled_body() > kMaxIndex ||
      p.field_body() > kMaxIndex || !IsRangeSound(p.first_plane(), n, p.num_planes(), core::kMaxContactPlanes) ||
      (!is_first && m->planes.size() != p.num_planes())) {
    return false;
  }
  m->pair_index = static_cast<std::uint16_t>(p.pair_index());
  m->sampled_body = static_cast<std::uint16_t>(p.sampled_body());
  m->field_body = static_cast<std::uint16_t>(p.field_body());
  m->cycle = p.cycle();
  m->signed_distance_m = p.signed_distance_m();
  m->is_in_contact = p.is_in_contact();
  m->F_So_W = GetWrench(p.f_so_w(), 0);
  m->damping_N_s_per_m = p.damping_n_s_per_m();
  m->friction = p.friction();
  if (is_first) m->planes.resize(p.num_planes());
  for (int i = 0; i < n; ++i) {
    core::ContactPlane& plane = m->planes[p.first_plane() + static_cast<std::uint32_t>(i)];
    plane.id = p.id(i);
    plane.p_S = Vec3(p.p_s(), 3 * i);
    plane.q_G = Vec3(p.q_g(), 3 * i);
    plane.n_G = Vec3(p.n_g(), 3 * i);
    plane.stiffness_N_per_m = p.stiffness_n_per_m(i);
  }
  return true;
}

bool Take(const oos::PhysicsState& p, bool is_first, core::PhysicsState* m) {
  const int n = p.object_size();
  const int k = p.mechanism_size();
  const auto is_index = [](std::uint32_t index) { return index <= kMaxIndex; };
  if (p.x_wo_size() != kPoseSize * n || p.v_wo_size() != kTwistSize * n || p.state_size() != k ||
      p.position_size() != k || p.force_size() != k ||
      !IsRangeSound(p.first_body(), n, p.num_bodies(), core::kMaxBodies) ||
      !IsRangeSound(p.first_mechanism(), k, p.num_mechanisms(), core::kMaxMechanisms) ||
      !std::all_of(p.object().begin(), p.object().end(), is_index) ||
      !std::all_of(p.mechanism().begin(), p.mechanism().end(), is_index) ||
      (!is_first && (m->bodies.size() != p.num_bodies() || m->mechanisms.size() != p.num_mechanisms()))) {
    return false;
  }
  m->tick = p.tick();
  m->time_ns = p.time_ns();
  m->is_in_contact = p.is_in_contact();
  m->state_hash = p.state_hash();
  if (is_first) {
    m->bodies.resize(p.num_bodies());
    m->mechanisms.resize(p.num_mechanisms());
  }
  for (int i = 0; i < n; ++i) {
    core::BodyState& body = m->bodies[p.first_body() + static_cast<std::uint32_t>(i)];
    body.object = static_cast<std::uint16_t>(p.object(i));
    body.X_WO = GetPose(p.x_wo(), kPoseSize * i);
    body.V_WO = GetTwist(p.v_wo(), kTwistSize * i);
  }
  for (int i = 0; i < k; ++i) {
    core::MechanismState& mechanism = m->mechanisms[p.first_mechanism() + static_cast<std::uint32_t>(i)];
    mechanism.mechanism = static_cast<std::uint16_t>(p.mechanism(i));
    mechanism.state = p.state(i);
    mechanism.position = p.position(i);
    mechanism.force = p.force(i);
  }
  return true;
}

bool Take(const oos::SheetState& p, bool is_first, core::SheetState* m) {
  const int n = p.p_w_size() / 3;
  if (p.p_w_size() != 3 * n || p.object() > kMaxIndex || p.num_columns() > kMaxIndex ||
      !IsRangeSound(p.first_node(), n, p.num_nodes(), core::kMaxSheetNodes) ||
      (p.num_columns() == 0 ? p.num_nodes() != 0 : p.num_nodes() % p.num_columns() != 0) ||
      (!is_first && m->p_W.size() != p.num_nodes())) {
    return false;
  }
  m->object = static_cast<std::uint16_t>(p.object());
  m->tick = p.tick();
  m->num_columns = static_cast<std::uint16_t>(p.num_columns());
  if (is_first) m->p_W.resize(p.num_nodes());
  for (int i = 0; i < n; ++i) m->p_W[p.first_node() + static_cast<std::uint32_t>(i)] = Vec3(p.p_w(), 3 * i);
  return true;
}

// Room for the largest message up front: the first contact of a run is no time to allocate.
void Reserve(oos::ContactSet* p) {
  constexpr int kPlanes = core::kMaxContactPlanes;
  p->mutable_f_so_w()->Reserve(kWrenchSize);
  p->mutable_id()->Reserve(kPlanes);
  p->mutable_stiffness_n_per_m()->Reserve(kPlanes);
  for (Floats* list : {p->mutable_p_s(), p->mutable_q_g(), p->mutable_n_g()}) list->Reserve(3 * kPlanes);
}
void Reserve(oos::PhysicsState* p) {
  constexpr int kBodies = core::kMaxBodies, kMechanisms = core::kMaxMechanisms;
  p->mutable_object()->Reserve(kBodies);
  p->mutable_x_wo()->Reserve(kPoseSize * kBodies);
  p->mutable_v_wo()->Reserve(kTwistSize * kBodies);
  p->mutable_mechanism()->Reserve(kMechanisms);
  p->mutable_state()->Reserve(kMechanisms);
  p->mutable_position()->Reserve(kMechanisms);
  p->mutable_force()->Reserve(kMechanisms);
}
void Reserve(oos::SheetState* p) {
  p->mutable_p_w()->Reserve(static_cast<int>(kMaxDatagramBytes / sizeof(float)));
}

struct Nothing {};  // detail/flat_codec.hpp needs no library
template <class M>
struct ProtoOf {
  using Type = Nothing;
};
template <>
struct ProtoOf<core::ContactSet> {
  using Type = oos::ContactSet;
};
template <>
struct ProtoOf<core::PhysicsState> {
  using Type = oos::PhysicsState;
};
template <>
struct ProtoOf<core::SheetState> {
  using Type = oos::SheetState;
};
template <class M>
constexpr bool kIsFlat = std::is_same_v<typename ProtoOf<M>::Type, Nothing>;

}  // namespace

template <class M>
struct LatestCodec<M>::Impl {
  typename ProtoOf<M>::Type message;
};

template <class M>
LatestCodec<M>::LatestCodec() : impl_(std::make_unique<Impl>()) {
  if constexpr (!kIsFlat<M>) Reserve(&impl_->message);
}
template <class M>
LatestCodec<M>::~LatestCodec() = default;

template <class M>
int LatestCodec<M>::NumParts(const M& message, std::size_t budget) const noexcept {
  if constexpr (std::is_same_v<M, core::PhysicsState>) {
    bool is_last = false;
    int parts = 1;
    while (PartOf(message, parts - 1, budget, &is_last), !is_last) ++parts;
    return parts;
  } else if constexpr (std::is_same_v<M, core::ContactSet>) {
    const std::size_t per_part = PlanesPerPart(budget);
    return static_cast<int>(std::max<std::size_t>((message.planes.size() + per_part - 1) / per_part, 1));
  } else if constexpr (std::is_same_v<M, core::SheetState>) {
    const std::size_t per_part = NodesPerPart(budget);
    return static_cast<int>(std::max<std::size_t>((message.p_W.size() + per_part - 1) / per_part, 1));
  } else {
    return 1;
  }
}

template <class M>
std::size_t LatestCodec<M>::Encode(const M& message, [[maybe_unused]] int part, [[maybe_unused]] std::size_t budget,
                                   std::uint8_t* out, std::size_t capacity) noexcept {
  if constexpr (kIsFlat<M>) {
    return detail::EncodeFlat(message, {out, capacity});
  } else {
    impl_->message.Clear();
    Fill(message, part, budget, &impl_->message);
    const std::size_t size = impl_->message.ByteSizeLong();
    if (size > capacity) return kDoesNotFit;
    impl_->message.SerializeWithCachedSizesToArray(out);
    return size;
  }
}

template <class M>
bool LatestCodec<M>::Decode(std::span<const std::uint8_t> payload, [[maybe_unused]] bool is_first,
                            M* message) noexcept {
  if constexpr (kIsFlat<M>) {
    return detail::DecodeFlat(payload, message);
  } else {
    if (!impl_->message.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) return false;
    return Take(impl_->message, is_first, message);
  }
}

template class LatestCodec<core::DeviceState>;
template class LatestCodec<core::DeviceCommand>;
template class LatestCodec<core::HapticProxy>;
template class LatestCodec<core::ContactSet>;
template class LatestCodec<core::PhysicsState>;
template class LatestCodec<core::Reaction>;
template class LatestCodec<core::SheetState>;

template <>
void EncodeState(const core::LogicStatus& value, std::string* bytes) {
  oos::LogicStatus p;
  p.set_time_ns(value.time_ns);
  p.set_step(value.step);
  p.set_hint(value.hint);
  for (const std::string& state : value.active_states) p.add_active_states(state);
  for (const core::LampState& lamp : value.lamps) {
    oos::Lamp* out = p.add_lamps();
    out->set_object(lamp.object);
    out->set_red(lamp.red);
    out->set_green(lamp.green);
    out->set_blue(lamp.blue);
  }
  p.set_is_final(value.is_final);
  p.set_is_failed(value.is_failed);
  p.set_why(value.why);
  p.SerializeToString(bytes);
}

template <>
bool DecodeState(const std::string& bytes, core::LogicStatus* value) {
  oos::LogicStatus p;
  if (!p.ParseFromString(bytes)) return false;
  core::LogicStatus status;
  status.time_ns = p.time_ns();
  status.step = p.step();
  status.hint = p.hint();
  status.active_states.assign(p.active_states().begin(), p.active_states().end());
  for (const oos::Lamp& lamp : p.lamps()) {
    if (lamp.object() > kMaxIndex) return false;
    status.lamps.push_back({static_cast<std::uint16_t>(lamp.object()), lamp.red(), lamp.green(), lamp.blue()});
  }
  status.is_final = p.is_final();
  status.is_failed = p.is_failed();
  status.why = p.why();
  *value = std::move(status);
  return true;
}

// From real-time threads, so without the library, which allocates for every name. Field 1: names, field 2: packed
// values.
template <>
void EncodeState(const Figures& value, std::string* bytes) {
  const auto put = [bytes](char tag, std::uint64_t size) {
    bytes->push_back(tag);
    for (; size >= 0x80; size >>= 7) bytes->push_back(static_cast<char>(size | 0x80));
    bytes->push_back(static_cast<char>(size));
  };
  bytes->clear();
  for (const Figure& figure : value.items) {
    put('\x0a', figure.name.size());
    bytes->append(figure.name);
  }
  if (value.items.empty()) return;
  put('\x12', sizeof(double) * value.items.size());
  for (const Figure& figure : value.items) {
    bytes->append(reinterpret_cast<const char*>(&figure.value), sizeof(double));
  }
}

template <>
bool DecodeState(const std::string& bytes, Figures* value) {
  oos::Figures p;
  if (!p.ParseFromString(bytes) || p.name_size() != p.value_size()) return false;
  Figures figures;
  for (int i = 0; i < p.name_size(); ++i) figures.items.push_back({p.name(i), p.value(i)});
  *value = std::move(figures);
  return true;
}

}  // namespace bus
