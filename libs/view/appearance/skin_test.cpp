#include "view/appearance/skin.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace view {
namespace {

// A bar along x with an elbow at x = 1: vertices at the shares of joint 1 (elbow) that are given, the rest of joint 0.
struct Bar {
  vps::VisualMesh mesh;
  vps::VisualMesh posed;

  explicit Bar(const std::vector<std::pair<glm::vec3, float>>& vertices) {
    mesh.primitives.resize(1);
    vps::VisualPrimitive& primitive = mesh.primitives[0];
    for (const auto& [p, share] : vertices) {
      primitive.positions.push_back(p);
      primitive.normals.emplace_back(0, 0, 1);
      primitive.joints.emplace_back(0, 1, 0, 0);
      primitive.weights.emplace_back(1.0f - share, share, 0, 0);
    }
    mesh.joints.push_back({"shoulder", {}, {}});
    mesh.joints.push_back({"elbow", {{1, 0, 0, 0}, {1, 0, 0}}, {{1, 0, 0, 0}, {-1, 0, 0}}});
    posed = mesh;
  }
  // The elbow turned about y, upwards for positive angles.
  const vps::VisualPrimitive& Bend(double angle_rad) {
    std::vector<core::Pose> X_MJ = RestPosture(mesh);
    X_MJ[1].rotation = glm::angleAxis(-angle_rad, glm::dvec3(0, 1, 0));
    BendSkin(mesh, X_MJ, &posed);
    return posed.primitives[0];
  }
};

TEST(Skin, AtRestLiesAsTheFileHasIt) {
  Bar bar({{{0.5f, 0.1f, 0.0f}, 0.0f}, {{1.0f, 0.1f, 0.0f}, 0.5f}, {{1.5f, -0.1f, 0.2f}, 1.0f}});
  EXPECT_EQ(bar.Bend(0.0).positions, bar.mesh.primitives[0].positions);
}

TEST(Skin, GoesRigidlyWithTheJointThatCarriesItAlone) {
  Bar bar({{{0.5f, 0.1f, 0.3f}, 0.0f}, {{1.5f, 0.1f, 0.3f}, 1.0f}});
  for (const double angle : {-2.0, 0.3, 1.5}) {
    const auto& bent = bar.Bend(angle);
    EXPECT_EQ(bent.positions[0], glm::vec3(0.5f, 0.1f, 0.3f));
    const double c = std::cos(angle), s = std::sin(angle);
    EXPECT_NEAR(bent.positions[1].x, 1.0 + 0.5 * c - 0.3 * s, 1e-6);
    EXPECT_NEAR(bent.positions[1].y, 0.1, 1e-6);
    EXPECT_NEAR(bent.positions[1].z, 0.5 * s + 0.3 * c, 1e-6);
    EXPECT_NEAR(bent.normals[1].x, -s, 1e-6);
    EXPECT_NEAR(bent.normals[1].z, c, 1e-6);
  }
}

// Where two joints share a vertex beside the elbow's axis, it comes nearer to the axis by the cosine of half the angle,
// and its normal halves the angle.
TEST(Skin, ThatTwoJointsShareLiesHalfWay) {
  Bar bar({{{1.0f, 0.0f, 0.2f}, 0.5f}});
  for (const double angle : {0.4, 1.2, 2.0}) {
    const auto& bent = bar.Bend(angle);
    const double shrunk = 0.2 * std::cos(0.5 * angle);
    EXPECT_NEAR(bent.positions[0].x, 1.0 - shrunk * std::sin(0.5 * angle), 1e-6);
    EXPECT_NEAR(bent.positions[0].z, shrunk * std::cos(0.5 * angle), 1e-6);
    EXPECT_NEAR(bent.normals[0].x, -std::sin(0.5 * angle), 1e-6);
    EXPECT_NEAR(bent.normals[0].z, std::cos(0.5 * angle), 1e-6);
  }
}

// Whoever moves all joints alike moves the whole skin.
TEST(Skin, TurnsAsAWholeWithAllItsJoints) {
  Bar bar({{{0.5f, 0.1f, 0.3f}, 0.25f}, {{1.5f, -0.1f, 0.3f}, 0.6f}});
  const core::Pose X = {glm::angleAxis(1.1, glm::normalize(glm::dvec3(1, -2, 3))), {4, 5, 6}};
  std::vector<core::Pose> X_MJ = RestPosture(bar.mesh);
  for (core::Pose& joint : X_MJ) joint = X * joint;
  BendSkin(bar.mesh, X_MJ, &bar.posed);
  for (std::size_t i = 0; i < 2; ++i) {
    const glm::dvec3 expected = X * glm::dvec3(bar.mesh.primitives[0].positions[i]);
    EXPECT_LT(glm::distance(glm::dvec3(bar.posed.primitives[0].positions[i]), expected), 1e-6);
  }
}

}  // namespace
}  // namespace view
