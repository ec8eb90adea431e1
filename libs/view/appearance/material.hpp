#pragma once

#include "view/scene.hpp"
#include "vps/mesh/load_mesh.hpp"

namespace view {

// What the scene says of a surface that a mesh file describes. Its textures stay with the mesh.
inline Material MaterialOf(const vps::VisualMaterial& given) {
  Material material;
  material.base_color = given.base_color;
  material.metallic = given.metallic;
  material.roughness = given.roughness;
  material.emissive = given.emissive;
  material.coat = given.coat;
  material.coat_roughness = given.coat_roughness;
  material.is_foil = given.is_foil;
  return material;
}

// The primitive's look by that name; its first one when `variant` is empty, or another primitive's.
inline const vps::VisualMaterial& LookOf(const vps::VisualPrimitive& primitive, const vps::VisualMesh& mesh,
                                         const std::string& variant) {
  for (std::size_t i = 0; i < primitive.variants.size() && !variant.empty(); ++i) {
    if (mesh.variants[i] == variant) return primitive.variants[i];
  }
  return primitive;
}

}  // namespace view
