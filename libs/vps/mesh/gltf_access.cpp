#include "vps/mesh/gltf_access.hpp"

namespace vps {

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

namespace {

// Four whole numbers for each vertex; `most` is the largest that their type holds.
bool ReadFour(const tinygltf::Model& model, const tinygltf::Accessor& accessor, std::vector<glm::u16vec4>* result,
              float* most) {
  if (accessor.type != TINYGLTF_TYPE_VEC4) return false;
  const bool is_byte = accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
  if (!is_byte && accessor.componentType != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) return false;
  *most = is_byte ? 255.0f : 65535.0f;
  for (std::size_t i = 0; i < accessor.count; ++i) {
    const unsigned char* bytes = Element(model, accessor, i, is_byte ? 4 : 8);
    if (bytes == nullptr) return false;
    glm::u16vec4 four;
    if (is_byte) {
      four = {bytes[0], bytes[1], bytes[2], bytes[3]};
    } else {
      std::memcpy(&four[0], bytes, 8);
    }
    result->push_back(four);
  }
  return true;
}

}  // namespace

bool ReadCounts(const tinygltf::Model& model, int accessor_index, std::vector<glm::u16vec4>* result) {
  if (accessor_index < 0 || accessor_index >= static_cast<int>(model.accessors.size())) return false;
  float most = 0.0f;
  return ReadFour(model, model.accessors[static_cast<std::size_t>(accessor_index)], result, &most);
}

bool ReadShares(const tinygltf::Model& model, int accessor_index, std::vector<glm::vec4>* result) {
  if (accessor_index < 0 || accessor_index >= static_cast<int>(model.accessors.size())) return false;
  const tinygltf::Accessor& accessor = model.accessors[static_cast<std::size_t>(accessor_index)];
  if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT) return ReadVectors(model, accessor_index, result);
  std::vector<glm::u16vec4> whole;
  float most = 0.0f;
  if (!ReadFour(model, accessor, &whole, &most)) return false;
  for (const glm::u16vec4& four : whole) result->push_back(glm::vec4(four) / most);
  return true;
}

bool ReadMatrices(const tinygltf::Model& model, int accessor_index, std::vector<glm::dmat4>* result) {
  if (accessor_index < 0 || accessor_index >= static_cast<int>(model.accessors.size())) return false;
  const tinygltf::Accessor& accessor = model.accessors[static_cast<std::size_t>(accessor_index)];
  if (accessor.type != TINYGLTF_TYPE_MAT4 || accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT) return false;
  for (std::size_t i = 0; i < accessor.count; ++i) {
    const unsigned char* bytes = Element(model, accessor, i, sizeof(glm::mat4));
    if (bytes == nullptr) return false;
    glm::mat4 matrix;
    std::memcpy(&matrix[0][0], bytes, sizeof matrix);
    result->emplace_back(matrix);
  }
  return true;
}

}  // namespace vps
