#include "vps/mesh/gltf_materials.hpp"

#include <algorithm>

namespace vps {
namespace {

constexpr const char* kVariants = "KHR_materials_variants";

// The extension's figure of that name.
float Figure(const tinygltf::ExtensionMap& extensions, const char* extension, const char* name, float otherwise) {
  const auto found = extensions.find(extension);
  if (found == extensions.end() || !found->second.Has(name)) return otherwise;
  const tinygltf::Value& value = found->second.Get(name);
  return value.IsNumber() ? static_cast<float>(value.GetNumberAsDouble()) : otherwise;
}

glm::vec3 Color(const std::vector<double>& factors, const glm::vec3& otherwise) {
  return factors.size() >= 3 ? glm::vec3(factors[0], factors[1], factors[2]) : otherwise;
}

}  // namespace

GltfMaterials::GltfMaterials(const tinygltf::Model& model) : model_(model) {
  const auto found = model.extensions.find(kVariants);
  if (found == model.extensions.end()) return;
  const tinygltf::Value& list = found->second.Get("variants");
  for (std::size_t i = 0; i < list.ArrayLen(); ++i) {
    const tinygltf::Value& name = list.Get(static_cast<int>(i)).Get("name");
    variants_.push_back(name.IsString() ? name.Get<std::string>() : std::string());
  }
}

void GltfMaterials::AddTo(const tinygltf::Primitive& primitive, VisualPrimitive* out) {
  const bool has_uvs = !out->uvs.empty();
  static_cast<VisualMaterial&>(*out) = Read(primitive.material, has_uvs);
  const auto found = primitive.extensions.find(kVariants);
  if (found == primitive.extensions.end()) return;
  out->variants.assign(variants_.size(), *out);
  const tinygltf::Value& mappings = found->second.Get("mappings");
  for (std::size_t i = 0; i < mappings.ArrayLen(); ++i) {
    const tinygltf::Value& mapping = mappings.Get(static_cast<int>(i));
    const tinygltf::Value& names = mapping.Get("variants");
    const VisualMaterial material = Read(mapping.Get("material").GetNumberAsInt(), has_uvs);
    for (std::size_t k = 0; k < names.ArrayLen(); ++k) {
      const int variant = names.Get(static_cast<int>(k)).GetNumberAsInt();
      if (variant >= 0 && variant < static_cast<int>(variants_.size())) {
        out->variants[static_cast<std::size_t>(variant)] = material;
      }
    }
  }
}

VisualMaterial GltfMaterials::Read(int index, bool has_uvs) {
  VisualMaterial out;
  if (index < 0 || index >= static_cast<int>(model_.materials.size())) return out;
  const tinygltf::Material& material = model_.materials[static_cast<std::size_t>(index)];
  const auto& pbr = material.pbrMetallicRoughness;
  out.base_color = Color(pbr.baseColorFactor, out.base_color);
  out.metallic = static_cast<float>(pbr.metallicFactor);
  out.roughness = static_cast<float>(pbr.roughnessFactor);
  out.emissive = Color(material.emissiveFactor, out.emissive) *
                 Figure(material.extensions, "KHR_materials_emissive_strength", "emissiveStrength", 1.0f);
  out.coat = std::clamp(Figure(material.extensions, "KHR_materials_clearcoat", "clearcoatFactor", 0.0f), 0.0f, 1.0f);
  out.coat_roughness =
      std::clamp(Figure(material.extensions, "KHR_materials_clearcoat", "clearcoatRoughnessFactor", 0.0f), 0.0f, 1.0f);
  out.transmission = Figure(material.extensions, "KHR_materials_transmission", "transmissionFactor", 0.0f);
  out.ior = std::max(Figure(material.extensions, "KHR_materials_ior", "ior", out.ior), 1.0f);
  out.has_material = true;
  out.is_foil = material.name.starts_with("mli");
  out.is_two_sided = material.doubleSided;
  out.is_lens = material.name.starts_with("lens");
  if (!has_uvs) return out;
  out.base_texture = Texture(pbr.baseColorTexture.index, true);
  out.surface_texture = Texture(pbr.metallicRoughnessTexture.index, false);
  out.normal_texture = Texture(material.normalTexture.index, false);
  out.emissive_texture = Texture(material.emissiveTexture.index, true);
  // Occlusion in a picture of its own would be another texture fetch at every pixel; it is not read.
  out.has_occlusion =
      out.surface_texture >= 0 && Image(material.occlusionTexture.index) == Image(pbr.metallicRoughnessTexture.index);
  return out;
}

int GltfMaterials::Image(int texture) const {
  if (texture < 0 || texture >= static_cast<int>(model_.textures.size())) return -1;
  const int image = model_.textures[static_cast<std::size_t>(texture)].source;
  return image < static_cast<int>(model_.images.size()) ? image : -1;
}

// The picture's place in textures_; -1 when there is none, or none was read.
int GltfMaterials::Texture(int texture, bool is_color) {
  const int image = Image(texture);
  if (image < 0) return -1;
  const tinygltf::Image& in = model_.images[static_cast<std::size_t>(image)];
  const auto width = static_cast<std::size_t>(in.width), height = static_cast<std::size_t>(in.height);
  if (in.bits != 8 || in.component != 4 || in.image.empty() || in.image.size() != 4 * width * height) return -1;
  const auto [place, is_new] = places_.try_emplace({image, is_color}, static_cast<int>(textures_.size()));
  if (is_new) textures_.push_back({in.width, in.height, in.image, is_color});
  return place->second;
}

}  // namespace vps
