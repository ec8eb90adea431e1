#include "vps/mesh/load_gltf.hpp"

#include <tiny_gltf.h>

#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <map>
#include <set>

namespace vps {
namespace {

// Without this callback tinygltf would decode the pictures of textures.
bool SkipImage(tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*, int, void*) {
  return true;
}

glm::dmat4 NodeTransform(const tinygltf::Node& node) {
  if (node.matrix.size() == 16) return glm::make_mat4(node.matrix.data());
  glm::dmat4 X(1.0);
  if (node.translation.size() == 3) X = glm::translate(X, glm::make_vec3(node.translation.data()));
  if (node.rotation.size() == 4) {
    const auto& q = node.rotation;  // x, y, z, w
    X *= glm::mat4_cast(glm::normalize(glm::dquat(q[3], q[0], q[1], q[2])));
  }
  if (node.scale.size() == 3) X = glm::scale(X, glm::make_vec3(node.scale.data()));
  return X;
}

// The bytes of element `index` of an accessor, or null when the file's own lengths do not hold together.
const unsigned char* Element(const tinygltf::Model& model, const tinygltf::Accessor& accessor, std::size_t index,
                             std::size_t num_bytes) {
  if (accessor.bufferView < 0 || accessor.bufferView >= static_cast<int>(model.bufferViews.size())) return nullptr;
  const tinygltf::BufferView& view = model.bufferViews[accessor.bufferView];
  if (view.buffer < 0 || view.buffer >= static_cast<int>(model.buffers.size())) return nullptr;
  const int stride = accessor.ByteStride(view);
  if (stride <= 0) return nullptr;
  const std::size_t begin = view.byteOffset + accessor.byteOffset + index * static_cast<std::size_t>(stride);
  const auto& data = model.buffers[view.buffer].data;
  return begin + num_bytes <= data.size() ? data.data() + begin : nullptr;
}

template <class Vec>
bool ReadVectors(const tinygltf::Model& model, int accessor_index, std::vector<Vec>* result) {
  static_assert(sizeof(Vec) == Vec::length() * sizeof(float));
  if (accessor_index < 0 || accessor_index >= static_cast<int>(model.accessors.size())) return false;
  const tinygltf::Accessor& accessor = model.accessors[accessor_index];
  const int type = Vec::length() == 3 ? TINYGLTF_TYPE_VEC3 : TINYGLTF_TYPE_VEC2;
  if (accessor.type != type || accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT) return false;
  for (std::size_t i = 0; i < accessor.count; ++i) {
    const unsigned char* bytes = Element(model, accessor, i, sizeof(Vec));
    if (bytes == nullptr) return false;
    Vec v;
    std::memcpy(&v[0], bytes, sizeof(Vec));
    result->push_back(v);
  }
  return true;
}

bool ReadIndices(const tinygltf::Model& model, int accessor_index, std::size_t num_vertices,
                 std::vector<std::uint32_t>* result) {
  if (accessor_index < 0) {
    for (std::size_t i = 0; i < num_vertices; ++i) result->push_back(static_cast<std::uint32_t>(i));
    return true;
  }
  if (accessor_index >= static_cast<int>(model.accessors.size())) return false;
  const tinygltf::Accessor& accessor = model.accessors[accessor_index];
  std::size_t size = 0;
  if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) size = 1;
  if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) size = 2;
  if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) size = 4;
  if (size == 0) return false;
  for (std::size_t i = 0; i < accessor.count; ++i) {
    const unsigned char* bytes = Element(model, accessor, i, size);
    if (bytes == nullptr) return false;
    std::uint32_t index = 0;
    std::memcpy(&index, bytes, size);
    if (index >= num_vertices) return false;
    result->push_back(index);
  }
  return true;
}

// Triangle list of a list, strip or fan.
std::vector<std::uint32_t> Triangulate(int mode, const std::vector<std::uint32_t>& in) {
  std::vector<std::uint32_t> out;
  if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
    for (std::size_t i = 2; i < in.size(); ++i) {
      const bool is_odd = i % 2 == 1;
      out.insert(out.end(), {in[i - 2], is_odd ? in[i] : in[i - 1], is_odd ? in[i - 1] : in[i]});
    }
  } else if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
    for (std::size_t i = 2; i < in.size(); ++i) out.insert(out.end(), {in[0], in[i - 1], in[i]});
  } else {
    out.assign(in.begin(), in.begin() + static_cast<std::ptrdiff_t>(in.size() / 3 * 3));
  }
  return out;
}

class Reader {
 public:
  Reader(const tinygltf::Model& model, double scale) : model_(model), scale_(scale) {}

  std::string Visit(int node_index, const glm::dmat4& X_parent, int depth) {
    if (node_index < 0 || node_index >= static_cast<int>(model_.nodes.size()) || depth > 256) {
      return "node " + std::to_string(node_index) + " does not exist or contains itself";
    }
    const tinygltf::Node& node = model_.nodes[node_index];
    const glm::dmat4 X = X_parent * NodeTransform(node);
    if (node.mesh >= static_cast<int>(model_.meshes.size()))
      return "node '" + node.name + "' names a mesh that is not there";
    if (node.mesh >= 0) {
      for (const auto& primitive : model_.meshes[node.mesh].primitives) {
        const std::string why = Add(primitive, X);
        if (!why.empty()) return "mesh '" + model_.meshes[node.mesh].name + "': " + why;
      }
    }
    for (const int child : node.children) {
      const std::string why = Visit(child, X, depth + 1);
      if (!why.empty()) return why;
    }
    return {};
  }

  VisualMesh result;

 private:
  std::string Add(const tinygltf::Primitive& primitive, const glm::dmat4& X) {
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP && mode != TINYGLTF_MODE_TRIANGLE_FAN) {
      return {};  // points and lines bound no volume
    }
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) return "a primitive has no POSITION";
    VisualPrimitive out;
    if (!ReadVectors(model_, position->second, &out.positions)) return "POSITION is not a complete float VEC3 accessor";
    std::vector<std::uint32_t> indices;
    if (!ReadIndices(model_, primitive.indices, out.positions.size(), &indices))
      return "indices are damaged or out of range";
    out.indices = Triangulate(mode, indices);
    const auto normal = primitive.attributes.find("NORMAL");
    if (normal != primitive.attributes.end()) {
      if (!ReadVectors(model_, normal->second, &out.normals) || out.normals.size() != out.positions.size()) {
        return "NORMAL does not fit POSITION";
      }
    }
    const auto uv = primitive.attributes.find("TEXCOORD_0");
    if (uv != primitive.attributes.end()) {
      if (!ReadVectors(model_, uv->second, &out.uvs) || out.uvs.size() != out.positions.size()) {
        return "TEXCOORD_0 is not a float VEC2 accessor that fits POSITION";
      }
    }
    const glm::dmat3 R(X);
    const glm::dmat3 R_normal = glm::transpose(glm::inverse(R));
    for (auto& p : out.positions) p = glm::vec3(scale_ * glm::dvec3(X * glm::dvec4(glm::dvec3(p), 1.0)));
    for (auto& n : out.normals) {
      const glm::dvec3 v = R_normal * glm::dvec3(n);
      const double length = glm::length(v);
      n = length > 0.0 ? glm::vec3(v / length) : glm::vec3(0, 0, 1);
    }
    if (glm::determinant(R) < 0.0) {  // a mirror turns triangles over
      for (std::size_t i = 0; i + 2 < out.indices.size(); i += 3) std::swap(out.indices[i + 1], out.indices[i + 2]);
    }
    if (primitive.material >= 0 && primitive.material < static_cast<int>(model_.materials.size())) {
      AddMaterial(model_.materials[primitive.material], &out);
    }
    if (!out.indices.empty()) result.primitives.push_back(std::move(out));
    return {};
  }

  void AddMaterial(const tinygltf::Material& material, VisualPrimitive* out) {
    const auto& pbr = material.pbrMetallicRoughness;
    if (pbr.baseColorFactor.size() >= 3) {
      out->base_color = glm::vec3(pbr.baseColorFactor[0], pbr.baseColorFactor[1], pbr.baseColorFactor[2]);
    }
    out->metallic = static_cast<float>(pbr.metallicFactor);
    out->roughness = static_cast<float>(pbr.roughnessFactor);
    out->has_material = true;
    out->is_foil = material.name.starts_with("mli");
    out->is_two_sided = material.doubleSided;
    out->is_lens = material.name.starts_with("lens");
    if (out->uvs.empty()) return;
    out->base_texture = Texture(pbr.baseColorTexture.index, true);
    out->surface_texture = Texture(pbr.metallicRoughnessTexture.index, false);
    out->normal_texture = Texture(material.normalTexture.index, false);
    // Occlusion in a picture of its own would be another texture fetch at every pixel; it is not read.
    out->has_occlusion = out->surface_texture >= 0 &&
                         Image(material.occlusionTexture.index) == Image(pbr.metallicRoughnessTexture.index);
  }

  [[nodiscard]] int Image(int texture) const {
    if (texture < 0 || texture >= static_cast<int>(model_.textures.size())) return -1;
    const int image = model_.textures[texture].source;
    return image < static_cast<int>(model_.images.size()) ? image : -1;
  }

  // The picture's place in the result; -1 when there is none, or none was read.
  int Texture(int texture, bool is_color) {
    const int image = Image(texture);
    if (image < 0) return -1;
    const tinygltf::Image& in = model_.images[image];
    const auto width = static_cast<std::size_t>(in.width), height = static_cast<std::size_t>(in.height);
    if (in.bits != 8 || in.component != 4 || in.image.empty() || in.image.size() != 4 * width * height) return -1;
    const auto [place, is_new] = places_.try_emplace({image, is_color}, static_cast<int>(result.textures.size()));
    if (is_new) result.textures.push_back({in.width, in.height, in.image, is_color});
    return place->second;
  }

  const tinygltf::Model& model_;
  double scale_;
  std::map<std::pair<int, bool>, int> places_;  // of pictures, in result.textures
};

}  // namespace

core::Result<VisualMesh> LoadGltfPrimitives(const std::filesystem::path& file, double scale, Pictures pictures) {
  tinygltf::TinyGLTF loader;
  if (pictures == Pictures::kSkip) loader.SetImageLoader(&SkipImage, nullptr);
  tinygltf::Model model;
  std::string error;
  std::string warning;
  const bool is_binary = file.extension() == ".glb" || file.extension() == ".GLB";
  const bool is_read = is_binary ? loader.LoadBinaryFromFile(&model, &error, &warning, file.string())
                                 : loader.LoadASCIIFromFile(&model, &error, &warning, file.string());
  if (!is_read) {
    return core::Fail(core::ErrorCode::kDamaged, file.string() + ": not a readable glTF 2.0 file: " + error);
  }
  std::vector<int> roots;
  if (!model.scenes.empty()) {
    const int scene =
        model.defaultScene >= 0 && model.defaultScene < static_cast<int>(model.scenes.size()) ? model.defaultScene : 0;
    roots = model.scenes[scene].nodes;
  } else {  // a file without a scene: every node that is nobody's child
    std::set<int> children;
    for (const auto& node : model.nodes) children.insert(node.children.begin(), node.children.end());
    for (int i = 0; i < static_cast<int>(model.nodes.size()); ++i) {
      if (!children.contains(i)) roots.push_back(i);
    }
  }
  Reader reader(model, scale);
  for (const int root : roots) {
    const std::string why = reader.Visit(root, glm::dmat4(1.0), 0);
    if (!why.empty()) return core::Fail(core::ErrorCode::kDamaged, file.string() + ": " + why);
  }
  return std::move(reader.result);
}

}  // namespace vps
