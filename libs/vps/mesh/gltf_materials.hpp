#pragma once

#include <tiny_gltf.h>

#include <map>
#include <utility>

#include "vps/mesh/load_mesh.hpp"

namespace vps {

// The looks of a glTF file's primitives: metallic-roughness, KHR_materials_emissive_strength, _clearcoat (its factors,
// no textures) and _variants. Each picture that one of them uses is kept once.
class GltfMaterials {
 public:
  explicit GltfMaterials(const tinygltf::Model& model);

  // The primitive's material and its variants. Its texture coordinates are there already.
  void AddTo(const tinygltf::Primitive& primitive, VisualPrimitive* out);

  [[nodiscard]] const std::vector<std::string>& variants() const { return variants_; }
  std::vector<VisualTexture> TakeTextures() { return std::move(textures_); }

 private:
  VisualMaterial Read(int material, bool has_uvs);
  [[nodiscard]] int Image(int texture) const;
  int Texture(int texture, bool is_color);

  const tinygltf::Model& model_;
  std::vector<std::string> variants_;
  std::vector<VisualTexture> textures_;
  std::map<std::pair<int, bool>, int> places_;  // of pictures, in textures_
};

}  // namespace vps
