#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/messages/device_fields.hpp"
#include "core/messages/haptic_fields.hpp"
#include "core/messages/logic_fields.hpp"
#include "core/messages/physics_fields.hpp"

namespace replay {

// Visits the fields of a message by name, so that encoding, decoding, comparing and listing a step all see the same
// fields in the same order. core::FieldsOf describes the messages; here are the types that they consist of.
//
// A visitor V has
//   static constexpr bool kReads        the visitor fills the fields
//   void Value(name, T&)                a number, enumeration or truth value
//   void Text(name, std::string&)
//   std::size_t Count(name, n)          number of items that follow; when reading, the number that was written
//   void Enter(name), Enter(name, index), Leave()
//   bool includes_transport                false: sequence numbers, send times and stamps are left out. They belong to
//   the
//                                       way between nodes, not to what a node computed.
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
  if (v.includes_transport) Items(v, "stamps", trace.stamps);
}

template <class V>
void Visit(V& v, core::Header& header) {
  if (v.includes_transport) {
    v.Value("sequence", header.sequence);
    v.Value("publish_ns", header.publish_ns);
  }
  Field(v, "direct", header.direct);
  Field(v, "through_physics", header.through_physics);
}

template <class V, class T>
void VisitMember(V& v, std::string_view name, T& value) {
  if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
    v.Value(name, value);
  } else if constexpr (std::is_same_v<T, std::string>) {
    v.Text(name, value);
  } else if constexpr (requires {
                         value.size();
                         value[0];
                         value.resize(0);
                       }) {
    Items(v, name, value);
  } else {
    Field(v, name, value);
  }
}

template <class V, core::HasFields M>
void Visit(V& v, M& message) {
  if constexpr (requires { message.header; }) Field(v, "header", message.header);
  core::ForEachField<M>([&](auto field) { VisitMember(v, field.name, field.Of(message)); });
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
