#include "view/appearance/skin.hpp"

#include <glm/gtc/quaternion.hpp>

namespace view {

void BendSkin(const vps::VisualMesh& mesh, std::span<const core::Pose> X_MJ, vps::VisualMesh* posed) {
  std::vector<glm::mat4x3> X_MMBind;  // of each joint
  for (std::size_t j = 0; j < mesh.joints.size(); ++j) {
    const core::Pose X = X_MJ[j] * mesh.joints[j].X_JMBind;
    const glm::mat3 R(glm::mat3_cast(X.rotation));
    X_MMBind.emplace_back(R[0], R[1], R[2], glm::vec3(X.translation));
  }
  for (std::size_t i = 0; i < mesh.primitives.size(); ++i) {
    const vps::VisualPrimitive& from = mesh.primitives[i];
    vps::VisualPrimitive& to = posed->primitives[i];
    for (std::size_t v = 0; v < from.joints.size(); ++v) {
      const glm::vec4& w = from.weights[v];
      const glm::u16vec4& j = from.joints[v];
      const glm::mat4x3 X = w.x * X_MMBind[j.x] + w.y * X_MMBind[j.y] + w.z * X_MMBind[j.z] + w.w * X_MMBind[j.w];
      to.positions[v] = X * glm::vec4(from.positions[v], 1.0f);
      const glm::vec3 n = X * glm::vec4(from.normals[v], 0.0f);
      const float length = glm::length(n);
      to.normals[v] = length > 0.0f ? n / length : from.normals[v];
    }
  }
}

std::vector<core::Pose> RestPosture(const vps::VisualMesh& mesh) {
  std::vector<core::Pose> X_MJ;
  for (const vps::VisualJoint& joint : mesh.joints) X_MJ.push_back(joint.X_MJ);
  return X_MJ;
}

}  // namespace view
