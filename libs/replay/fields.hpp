#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/messages/device.hpp"
#include "core/messages/haptic.hpp"
#include "core/messages/logic.hpp"
#include "core/messages/physics.hpp"

namespace replay {

// The fields of a message, one after the other, by name: what writes a step, reads it, compares two and names their
// fields all see the same fields in the same order.
//
// A visitor V has
//   static constexpr bool kReads        fields are to be filled
//   void Value(name, T&)                a number, enumeration or truth value
//   void Text(name, std::string&)
//   std::size_t Count(name, n)          of items that follow; when reading, how many were written
//   void Enter(name), Enter(name, index), Leave()
//   bool tells_transport                false: sequence numbers, send times and stamps are left out. They are of the
//   way
//                                       between nodes, not of what a node computed.
template <class V, class T>
void Field(V& v, std::string_view name, T& value);

template <class V, class List>
void Items(V& v, std::string_view name, List& list) {
  const std::size_t count = v.Count(name, list.size());
  if constexpr (V::kReads) {
    if constexpr (requires { List::kCapacity; }) {
      if (count > List::kCapacity) return v.Fail();
    }
    list.resize(count);
  }
  for (std::size_t i = 0; i < count; ++i) {
    v.Enter(name, i);
    if constexpr (std::is_arithmetic_v<std::remove_reference_t<decltype(list[i])>>) {
      v.Value("", list[i]);
    } else if constexpr (std::is_same_v<std::remove_reference_t<decltype(list[i])>, std::string>) {
      v.Text("", list[i]);
    } else {
      Visit(v, list[i]);
    }
    v.Leave();
  }
}

template <class V>
void Visit(V& v, glm::dvec3& x) {
  v.Value("x", x.x);
  v.Value("y", x.y);
  v.Value("z", x.z);
}

template <class V>
void Visit(V& v, glm::vec3& x) {
  v.Value("x", x.x);
  v.Value("y", x.y);
  v.Value("z", x.z);
}

template <class V>
void Visit(V& v, glm::dquat& q) {
  v.Value("w", q.w);
  v.Value("x", q.x);
  v.Value("y", q.y);
  v.Value("z", q.z);
}

template <class V>
void Visit(V& v, core::Pose& X) {
  Field(v, "rotation", X.rotation);
  Field(v, "translation", X.translation);
}

template <class V>
void Visit(V& v, core::Twist& V_WB) {
  Field(v, "angular_rad_per_s", V_WB.angular_rad_per_s);
  Field(v, "linear_m_per_s", V_WB.linear_m_per_s);
}

template <class V>
void Visit(V& v, core::Wrench& F) {
  Field(v, "force_N", F.force_N);
  Field(v, "torque_Nm", F.torque_Nm);
}

template <class V>
void Visit(V& v, core::Stamp& stamp) {
  v.Value("stage", stamp.stage);
  v.Value("offset_ns", stamp.offset_ns);
}

template <class V>
void Visit(V& v, core::Trace& trace) {
  v.Value("id", trace.id);
  v.Value("origin_ns", trace.origin_ns);
  if (v.tells_transport) Items(v, "stamps", trace.stamps);
}

template <class V>
void Visit(V& v, core::Header& header) {
  if (v.tells_transport) {
    v.Value("sequence", header.sequence);
    v.Value("publish_ns", header.publish_ns);
  }
  Field(v, "direct", header.direct);
  Field(v, "through_physics", header.through_physics);
}

template <class V>
void Visit(V& v, core::DeviceState& state) {
  Field(v, "header", state.header);
  v.Value("role_index", state.role_index);
  v.Value("sample_ns", state.sample_ns);
  Field(v, "X_WD", state.X_WD);
  Field(v, "V_WD", state.V_WD);
  v.Value("opening_m", state.opening_m);
  v.Value("opening_velocity_m_per_s", state.opening_velocity_m_per_s);
  v.Value("is_engaged", state.is_engaged);
  v.Value("is_simulated", state.is_simulated);
}

template <class V>
void Visit(V& v, core::DeviceCommand& command) {
  Field(v, "header", command.header);
  v.Value("role_index", command.role_index);
  Field(v, "F_Do_W", command.F_Do_W);
  v.Value("grip_force_N", command.grip_force_N);
  v.Value("validity_ns", command.validity_ns);
}

template <class V>
void Visit(V& v, core::HapticProxy& proxy) {
  Field(v, "header", proxy.header);
  v.Value("role_index", proxy.role_index);
  v.Value("cycle", proxy.cycle);
  Field(v, "X_WD", proxy.X_WD);
  Field(v, "V_WD", proxy.V_WD);
  Field(v, "X_WC", proxy.X_WC);
  v.Value("opening_m", proxy.opening_m);
  v.Value("is_in_contact", proxy.is_in_contact);
  v.Value("is_engaged", proxy.is_engaged);
  Field(v, "F_Do_W", proxy.F_Do_W);
}

template <class V>
void Visit(V& v, core::ContactPlane& plane) {
  v.Value("id", plane.id);
  Field(v, "p_S", plane.p_S);
  Field(v, "q_G", plane.q_G);
  Field(v, "n_G", plane.n_G);
  v.Value("stiffness_N_per_m", plane.stiffness_N_per_m);
}

template <class V>
void Visit(V& v, core::ContactSet& set) {
  Field(v, "header", set.header);
  v.Value("pair_index", set.pair_index);
  v.Value("sampled_body", set.sampled_body);
  v.Value("field_body", set.field_body);
  v.Value("cycle", set.cycle);
  v.Value("signed_distance_m", set.signed_distance_m);
  v.Value("is_in_contact", set.is_in_contact);
  Field(v, "F_So_W", set.F_So_W);
  v.Value("damping_N_s_per_m", set.damping_N_s_per_m);
  v.Value("friction", set.friction);
  Items(v, "planes", set.planes);
}

template <class V>
void Visit(V& v, core::BodyState& body) {
  v.Value("object", body.object);
  Field(v, "X_WO", body.X_WO);
  Field(v, "V_WO", body.V_WO);
}

template <class V>
void Visit(V& v, core::MechanismState& mechanism) {
  v.Value("mechanism", mechanism.mechanism);
  v.Value("state", mechanism.state);
  v.Value("position", mechanism.position);
  v.Value("force", mechanism.force);
}

template <class V>
void Visit(V& v, core::PhysicsState& state) {
  Field(v, "header", state.header);
  v.Value("tick", state.tick);
  v.Value("time_ns", state.time_ns);
  v.Value("is_in_contact", state.is_in_contact);
  Items(v, "bodies", state.bodies);
  Items(v, "mechanisms", state.mechanisms);
  v.Value("state_hash", state.state_hash);  // last: what differs shall be named by a figure first
}

template <class V>
void Visit(V& v, core::Reaction& reaction) {
  Field(v, "header", reaction.header);
  v.Value("role_index", reaction.role_index);
  v.Value("tick", reaction.tick);
  v.Value("grasped_object", reaction.grasped_object);
  Field(v, "F_Do_W", reaction.F_Do_W);
}

template <class V>
void Visit(V& v, core::LampState& lamp) {
  v.Value("object", lamp.object);
  v.Value("red", lamp.red);
  v.Value("green", lamp.green);
  v.Value("blue", lamp.blue);
}

template <class V>
void Visit(V& v, core::LogicStatus& status) {
  v.Value("time_ns", status.time_ns);
  v.Text("step", status.step);
  v.Text("hint", status.hint);
  Items(v, "active_states", status.active_states);
  Items(v, "lamps", status.lamps);
  v.Value("is_final", status.is_final);
  v.Value("is_failed", status.is_failed);
  v.Text("why", status.why);
}

template <class V>
void Visit(V& v, core::ParameterChange& change) {
  v.Text("name", change.name);
  v.Value("value", change.value);
  v.Value("manner", change.manner);
  v.Value("ramp_s", change.ramp_s);
}

template <class V>
void Visit(V& v, core::Event& event) {
  v.Value("time_ns", event.time_ns);
  v.Text("source", event.source);
  v.Text("name", event.name);
  v.Text("detail", event.detail);
}

template <class V, class T>
void Field(V& v, std::string_view name, T& value) {
  v.Enter(name);
  Visit(v, value);
  v.Leave();
}

// A pointer to so many items. `memory` holds them when reading.
template <class V, class M>
void ItemsAt(V& v, std::string_view name, const M*& items, std::size_t& num_items, std::vector<M>* memory) {
  const std::size_t count = v.Count(name, num_items);
  if constexpr (V::kReads) {
    memory->resize(count);
    items = memory->data();
    num_items = count;
  }
  for (std::size_t i = 0; i < count; ++i) {
    v.Enter(name, i);
    Visit(v, const_cast<M&>(items[i]));  // a visitor that does not read leaves it alone
    v.Leave();
  }
}

// A pointer to a message that may be missing. `memory` holds it when reading.
template <class V, class M>
void Optional(V& v, std::string_view name, const M*& message, M* memory) {
  const bool is_there = v.Count(name, message != nullptr ? 1 : 0) != 0;
  if constexpr (V::kReads) message = is_there ? memory : nullptr;
  if (!is_there) return;
  v.Enter(name);
  Visit(v, const_cast<M&>(*message));  // a visitor that does not read leaves it alone
  v.Leave();
}

}  // namespace replay
