#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>

#include "core/pose.hpp"
#include "proto/web_scene.pb.h"
#include "view/scene.hpp"

namespace scene_stream {

// Numbers as the messages of proto/web_scene.proto have them.

template <class Field>
void Put(const glm::vec3& v, Field* field) {
  for (int i = 0; i < 3; ++i) field->Add(v[i]);
}
template <class Field>
void Put(const glm::dvec3& v, Field* field) {
  for (int i = 0; i < 3; ++i) field->Add(v[i]);
}
template <class Field>
void Put(const glm::dquat& q, Field* field) {
  for (const double x : {q.w, q.x, q.y, q.z}) field->Add(x);
}
template <class Field>
void Put(const core::Pose& X_AB, Field* field) {
  Put(X_AB.rotation, field);
  Put(X_AB.translation, field);
}

// Appends values as they lie in memory: little-endian, on every machine that this runs on.
template <class T>
void Append(std::span<const T> values, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
}
inline void Append(const glm::vec3& v, std::string* bytes) {
  Append(std::span<const float>(&v.x, 3), bytes);
}

// As seven floats, quaternion first.
inline void Append(const core::Pose& X_AB, std::string* bytes) {
  const glm::quat q(X_AB.rotation);
  const glm::vec3 p(X_AB.translation);
  for (const float x : {q.w, q.x, q.y, q.z, p.x, p.y, p.z}) Append(std::span<const float>(&x, 1), bytes);
}

inline void Put(const view::Material& material, oos::SceneSurface* surface) {
  Put(material.base_color, surface->mutable_base_color());
  surface->set_metallic(material.metallic);
  surface->set_roughness(material.roughness);
  Put(material.emissive, surface->mutable_emissive());
  surface->set_is_foil(material.is_foil);
  surface->set_coat(material.coat);
  surface->set_coat_roughness(material.coat_roughness);
}

}  // namespace scene_stream
