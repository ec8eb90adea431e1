#include "nodes/visual_node/gl/closed_mesh.hpp"

#include <gtest/gtest.h>

namespace visual_node {
namespace {

// A tetrahedron in two primitives, its base (0) and its sides, as a file with two materials has it.
vps::VisualMesh Tetrahedron() {
  const std::vector<glm::vec3> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  vps::VisualMesh mesh;
  mesh.primitives.resize(2);
  for (vps::VisualPrimitive& primitive : mesh.primitives) primitive.positions = corners;
  mesh.primitives[0].indices = {0, 2, 1};
  mesh.primitives[1].indices = {0, 1, 3, 1, 2, 3, 2, 0, 3};
  return mesh;
}

TEST(ClosedMesh, ATetrahedronOfTwoMaterialsIsClosed) {
  EXPECT_TRUE(IsClosedAndFacesOutwards(Tetrahedron()));
}

TEST(ClosedMesh, WithoutItsBaseItIsOpen) {
  vps::VisualMesh mesh = Tetrahedron();
  mesh.primitives.erase(mesh.primitives.begin());
  EXPECT_FALSE(IsClosedAndFacesOutwards(mesh));
}

TEST(ClosedMesh, WithOneFaceTurnedItIsOpen) {
  vps::VisualMesh mesh = Tetrahedron();
  std::swap(mesh.primitives[0].indices[0], mesh.primitives[0].indices[1]);
  EXPECT_FALSE(IsClosedAndFacesOutwards(mesh));
}

TEST(ClosedMesh, APartThatFacesInwardsIsFoundBesideALargerOneThatDoesNot) {
  vps::VisualMesh mesh = Tetrahedron();
  vps::VisualMesh inside_out = Tetrahedron();
  for (vps::VisualPrimitive& primitive : inside_out.primitives) {
    for (glm::vec3& p : primitive.positions) p = 0.1f * p + glm::vec3(5.0f);
    for (std::size_t i = 0; i < primitive.indices.size(); i += 3) {
      std::swap(primitive.indices[i], primitive.indices[i + 1]);
    }
    mesh.primitives.push_back(primitive);
  }
  EXPECT_FALSE(IsClosedAndFacesOutwards(mesh));
}

TEST(ClosedMesh, NothingIsNotClosed) {
  EXPECT_FALSE(IsClosedAndFacesOutwards({}));
}

}  // namespace
}  // namespace visual_node
