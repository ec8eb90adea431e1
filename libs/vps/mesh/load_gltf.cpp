#include "vps/mesh/load_gltf.hpp"

#include <tiny_gltf.h>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <set>

#include "vps/mesh/gltf_access.hpp"
#include "vps/mesh/gltf_materials.hpp"
#include "vps/mesh/gltf_skins.hpp"

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
  Reader(const tinygltf::Model& model, double scale)
      : model_(model), scale_(scale), materials_(model), skins_(model, scale) {}

  std::string Visit(int node_index, const glm::dmat4& X_parent, int depth) {
    if (node_index < 0 || node_index >= static_cast<int>(model_.nodes.size()) || depth > 256) {
      return "node " + std::to_string(node_index) + " does not exist or contains itself";
    }
    const tinygltf::Node& node = model_.nodes[node_index];
    const glm::dmat4 X = X_parent * NodeTransform(node);
    skins_.Place(node_index, X);
    if (node.mesh >= static_cast<int>(model_.meshes.size()))
      return "node '" + node.name + "' names a mesh that is not there";
    if (node.mesh >= 0) {
      for (const auto& primitive : model_.meshes[node.mesh].primitives) {
        const std::string why = Add(primitive, node.skin < 0 ? X : glm::dmat4(1.0), node.skin);
        if (!why.empty()) return "mesh '" + model_.meshes[node.mesh].name + "': " + why;
      }
    }
    for (const int child : node.children) {
      const std::string why = Visit(child, X, depth + 1);
      if (!why.empty()) return why;
    }
    return {};
  }

  // After all nodes have been visited. Empty, or what is wrong with a skin.
  std::string Finish() {
    result.variants = materials_.variants();
    result.textures = materials_.TakeTextures();
    return skins_.Finish(&result.joints);
  }

  VisualMesh result;

 private:
  std::string Add(const tinygltf::Primitive& primitive, const glm::dmat4& X, int skin) {
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
    materials_.AddTo(primitive, &out);
    if (skin >= 0) {
      const std::string why = skins_.AddTo(skin, primitive, &out);
      if (!why.empty()) return why;
    }
    if (!out.indices.empty()) result.primitives.push_back(std::move(out));
    return {};
  }

  const tinygltf::Model& model_;
  double scale_;
  GltfMaterials materials_;
  GltfSkins skins_;
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
  const std::string why = reader.Finish();
  if (!why.empty()) return core::Fail(core::ErrorCode::kDamaged, file.string() + ": " + why);
  return std::move(reader.result);
}

}  // namespace vps
