#pragma once

#include <charconv>
#include <cmath>
#include <string>

#include "scene/element_reader.hpp"

// How elements that the loader adds are written.
namespace scene {

inline std::string NumberText(double value) {
  char text[32];
  const auto result = std::to_chars(text, text + sizeof(text), value);  // the shortest that reads back the same
  return {text, result.ptr};
}

inline std::string VectorText(const glm::dvec3& v) {
  return NumberText(v.x) + " " + NumberText(v.y) + " " + NumberText(v.z);
}

// Roll, pitch and yaw [rad] about the fixed axes x, y, z: R = Rz(yaw) Ry(pitch) Rx(roll), of which the entries are
//   R_xx = cos(pitch) cos(yaw), R_yx = cos(pitch) sin(yaw), R_zx = -sin(pitch), R_zy = cos(pitch) sin(roll), ...
// At a pitch of 90 degrees roll and yaw turn about the same axis (gimbal lock), and yaw is set to 0.
inline glm::dvec3 RollPitchYaw(const glm::dquat& rotation) {
  const glm::dmat3 R = glm::mat3_cast(rotation);  // [column][row]
  const double cos_pitch = std::hypot(R[0][0], R[0][1]);
  const double pitch = std::atan2(-R[0][2], cos_pitch);
  if (cos_pitch < 1e-8) return {std::atan2(-R[2][1], R[1][1]), pitch, 0.0};
  return {std::atan2(R[1][2], R[2][2]), pitch, std::atan2(R[0][1], R[0][0])};
}

inline void SetAttribute(XmlElement* element, const std::string& name, const std::string& value) {
  element->attributes.push_back({{}, name, value, element->line});
}

inline void SetPose(XmlElement* element, const core::Pose& X_W) {
  SetAttribute(element, "position", VectorText(X_W.translation));
  SetAttribute(element, "rpy_deg", VectorText(RollPitchYaw(X_W.rotation) / kRadPerDeg));
}

inline void CopyAttributes(const XmlElement& from, std::initializer_list<const char*> names, XmlElement* to) {
  for (const char* name : names) {
    if (from.Find(name) != nullptr) SetAttribute(to, name, from.Get(name));
  }
}

}  // namespace scene
