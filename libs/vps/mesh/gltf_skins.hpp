#pragma once

#include <tiny_gltf.h>

#include <map>
#include <string>

#include "vps/mesh/load_mesh.hpp"

namespace vps {

// The skins of a glTF file: joints of all of them in one list. A mesh at a node that has a skin is where its joints
// are; the node's own pose does not count, as glTF says.
class GltfSkins {
 public:
  GltfSkins(const tinygltf::Model& model, double scale) : model_(model), scale_(scale) {}

  // Joints and weights of a primitive at a node that has this skin. Empty, or what is wrong with it.
  std::string AddTo(int skin, const tinygltf::Primitive& primitive, VisualPrimitive* out);

  // The pose of each node is known once all have been visited.
  void Place(int node, const glm::dmat4& X_MN) { X_MN_[node] = X_MN; }
  // The joints that primitives use, at their nodes. Empty, or what is wrong.
  std::string Finish(std::vector<VisualJoint>* joints) const;

 private:
  const tinygltf::Model& model_;
  double scale_;
  std::map<int, glm::dmat4> X_MN_;
  std::map<int, std::size_t> first_;  // of a skin: its first joint in the list
  std::vector<int> nodes_;            // of each joint
  std::vector<glm::dmat4> X_JMBind_;  // of each joint
};

}  // namespace vps
