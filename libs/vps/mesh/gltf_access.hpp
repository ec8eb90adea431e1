#pragma once

#include <tiny_gltf.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <vector>

namespace vps {

// The numbers of a glTF file's accessors. All return false, or null, when the file's own lengths do not hold together.

// The bytes of element `index` of an accessor.
const unsigned char* Element(const tinygltf::Model& model, const tinygltf::Accessor& accessor, std::size_t index,
                             std::size_t num_bytes);

// Vectors of floats.
template <class Vec>
bool ReadVectors(const tinygltf::Model& model, int accessor_index, std::vector<Vec>* result) {
  static_assert(sizeof(Vec) == Vec::length() * sizeof(float));
  if (accessor_index < 0 || accessor_index >= static_cast<int>(model.accessors.size())) return false;
  const tinygltf::Accessor& accessor = model.accessors[static_cast<std::size_t>(accessor_index)];
  constexpr std::array<int, 5> kTypes = {0, 0, TINYGLTF_TYPE_VEC2, TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4};
  if (accessor.type != kTypes[Vec::length()] || accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT) return false;
  for (std::size_t i = 0; i < accessor.count; ++i) {
    const unsigned char* bytes = Element(model, accessor, i, sizeof(Vec));
    if (bytes == nullptr) return false;
    Vec v;
    std::memcpy(&v[0], bytes, sizeof(Vec));
    result->push_back(v);
  }
  return true;
}

// Vertex numbers below `num_vertices`; accessor -1: all in turn.
bool ReadIndices(const tinygltf::Model& model, int accessor_index, std::size_t num_vertices,
                 std::vector<std::uint32_t>* result);

// Four whole numbers of one or two bytes each.
bool ReadCounts(const tinygltf::Model& model, int accessor_index, std::vector<glm::u16vec4>* result);
// Four shares: floats, or whole numbers of one or two bytes of which the largest is 1.
bool ReadShares(const tinygltf::Model& model, int accessor_index, std::vector<glm::vec4>* result);
// Matrices of floats, column by column.
bool ReadMatrices(const tinygltf::Model& model, int accessor_index, std::vector<glm::dmat4>* result);

}  // namespace vps
