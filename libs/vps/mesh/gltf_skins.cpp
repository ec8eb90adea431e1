#include "vps/mesh/gltf_skins.hpp"

#include <cmath>
#include <limits>
#include <optional>

#include "vps/mesh/gltf_access.hpp"

namespace vps {
namespace {

// None when the matrix does more than turn and move.
std::optional<core::Pose> RigidPart(const glm::dmat4& X, double scale) {
  constexpr double kSingle = 1e-4;  // matrices of joints are stored as floats, and are products of several
  const glm::dmat3 R(X), off = glm::transpose(R) * R - glm::dmat3(1.0);
  for (int i = 0; i < 3; ++i) {
    if (glm::length(off[i]) > kSingle) return std::nullopt;
  }
  if (glm::determinant(R) < 0.0) return std::nullopt;
  return core::Pose{glm::normalize(glm::quat_cast(R)), scale * glm::dvec3(X[3])};
}

}  // namespace

std::string GltfSkins::AddTo(int skin, const tinygltf::Primitive& primitive, VisualPrimitive* out) {
  if (skin >= static_cast<int>(model_.skins.size())) return "its node names a skin that is not there";
  const tinygltf::Skin& in = model_.skins[static_cast<std::size_t>(skin)];
  const auto [first, is_new] = first_.try_emplace(skin, nodes_.size());
  if (is_new) {
    std::vector<glm::dmat4> bind;
    if (in.inverseBindMatrices >= 0 && !ReadMatrices(model_, in.inverseBindMatrices, &bind))
      return "inverseBindMatrices is not a complete float MAT4 accessor";
    if (in.inverseBindMatrices < 0) bind.assign(in.joints.size(), glm::dmat4(1.0));
    if (bind.size() < in.joints.size()) return "the skin has fewer inverse bind matrices than joints";
    for (std::size_t i = 0; i < in.joints.size(); ++i) {
      nodes_.push_back(in.joints[i]);
      X_JMBind_.push_back(bind[i]);
    }
    if (nodes_.size() > std::numeric_limits<std::uint16_t>::max()) return "its skins have too many joints";
  }
  if (primitive.attributes.contains("JOINTS_1")) return "a vertex has more than four joints; limit them to four";
  const auto joints = primitive.attributes.find("JOINTS_0"), weights = primitive.attributes.find("WEIGHTS_0");
  if (joints == primitive.attributes.end() || weights == primitive.attributes.end())
    return "a primitive with a skin has no JOINTS_0 or WEIGHTS_0";
  if (!ReadCounts(model_, joints->second, &out->joints) || out->joints.size() != out->positions.size())
    return "JOINTS_0 does not fit POSITION";
  if (!ReadShares(model_, weights->second, &out->weights) || out->weights.size() != out->positions.size())
    return "WEIGHTS_0 does not fit POSITION";
  for (std::size_t i = 0; i < out->joints.size(); ++i) {
    glm::vec4& w = out->weights[i];
    const float sum = w.x + w.y + w.z + w.w;
    if (!(sum > 0.5f && sum < 1.5f) || glm::any(glm::lessThan(w, glm::vec4(0.0f))))
      return "the weights of vertex " + std::to_string(i) + " do not add up to 1";
    w /= sum;
    for (int k = 0; k < 4; ++k) {
      if (w[k] == 0.0f) out->joints[i][k] = 0;
      if (out->joints[i][k] >= in.joints.size())
        return "vertex " + std::to_string(i) + " has a joint that is not there";
      out->joints[i][k] = static_cast<std::uint16_t>(out->joints[i][k] + first->second);
    }
  }
  return {};
}

std::string GltfSkins::Finish(std::vector<VisualJoint>* joints) const {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const auto placed = X_MN_.find(nodes_[i]);
    if (placed == X_MN_.end()) return "joint " + std::to_string(i) + " of its skin is not in the scene";
    const std::string& name = model_.nodes[static_cast<std::size_t>(nodes_[i])].name;
    const auto X_MJ = RigidPart(placed->second, scale_), X_JMBind = RigidPart(X_JMBind_[i], scale_);
    if (!X_MJ || !X_JMBind)
      return "joint '" + name + "' of its skin stretches; apply the scale of the skeleton before the export";
    joints->push_back({name, *X_MJ, *X_JMBind});
  }
  return {};
}

}  // namespace vps
