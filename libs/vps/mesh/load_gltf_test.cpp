#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <string>

#include "vps/mesh/load_mesh.hpp"

namespace vps {
namespace {

// A glTF file of one triangle (0,0,0) (1,0,0) (0,1,0) with normals, texture coordinates, joints and weights.
class GltfTest : public testing::Test {
 protected:
  // Writes .gltf and .bin; `more` are further members of the document, `attributes` of the primitive.
  core::Result<VisualMesh> Load(const std::string& node, const std::string& primitive, const std::string& more,
                                double scale = 1.0) {
    const auto folder = std::filesystem::path(testing::TempDir());
    std::string bytes;
    const auto put = [&](const auto& numbers) {
      bytes.append(reinterpret_cast<const char*>(numbers), sizeof numbers);  // NOLINT: the bytes of a file
    };
    const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, normals[] = {0, 0, 1, 0, 0, 1, 0, 0, 1};
    const std::uint8_t joints[] = {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0};
    put(positions);
    put(normals);
    put(joints);
    put(weights_);
    put(bind_);
    std::ofstream(folder / "vps_gltf.bin", std::ios::binary) << bytes;
    const auto view = [](int offset, int length) {
      return R"({"buffer":0,"byteOffset":)" + std::to_string(offset) + R"(,"byteLength":)" + std::to_string(length) +
             "}";
    };
    const auto accessor = [](int view_index, int component, int count, const char* type) {
      return R"({"bufferView":)" + std::to_string(view_index) + R"(,"componentType":)" + std::to_string(component) +
             R"(,"count":)" + std::to_string(count) + R"(,"type":")" + type + "\"}";
    };
    const auto file = folder / "vps_gltf.gltf";
    std::ofstream(file) << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[)" << node
                        << R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1)" << primitive
                        << R"(}]}],"accessors":[)" << accessor(0, 5126, 3, "VEC3") << ","
                        << accessor(1, 5126, 3, "VEC3") << "," << accessor(2, 5121, 3, "VEC4") << ","
                        << accessor(3, 5126, 3, "VEC4") << "," << accessor(4, 5126, 2, "MAT4") << R"(],"bufferViews":[)"
                        << view(0, 36) << "," << view(36, 36) << "," << view(72, 12) << "," << view(84, 48) << ","
                        << view(132, 128) << R"(],"buffers":[{"uri":)"
                        << R"("vps_gltf.bin","byteLength":260}])" << more << "}";
    return LoadVisualMesh(file, scale);
  }
  core::Result<VisualMesh> LoadSkin(const std::string& joint_1, double scale = 1.0) {
    return Load(R"({"children":[1,2],"translation":[0,0,9]},{"mesh":0,"skin":0,"translation":[7,0,0]},
                   {"name":"base","children":[3]},)" +
                    joint_1,
                R"(,"JOINTS_0":2,"WEIGHTS_0":3})", R"(,"skins":[{"joints":[2,3],"inverseBindMatrices":4}])", scale);
  }

  float weights_[12] = {1, 0, 0, 0, 1, 0, 0, 0, 0.25f, 0.75f, 0, 0};
  // Of "base": the unit matrix; of "tip": from 2 along x.
  float bind_[32] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -2, 0, 0, 1};
};

TEST_F(GltfTest, ASkinHasItsJointsPosesAndWeights) {
  const auto mesh = LoadSkin(R"({"name":"tip","translation":[2,0,1],"rotation":[0,0,0.70710678,0.70710678]})", 0.001);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  ASSERT_EQ(mesh->joints.size(), 2u);
  EXPECT_EQ(mesh->joints[0].name, "base");
  EXPECT_EQ(mesh->joints[1].name, "tip");
  EXPECT_NEAR(mesh->joints[0].X_MJ.translation.z, 0.009, 1e-9) << "with its parent's pose, in metres";
  EXPECT_LT(glm::distance(mesh->joints[1].X_MJ.translation, glm::dvec3(0.002, 0, 0.010)), 1e-9);
  EXPECT_LT(glm::distance(mesh->joints[1].X_MJ.rotate({1, 0, 0}), glm::dvec3(0, 1, 0)), 1e-6);
  EXPECT_LT(glm::distance(mesh->joints[1].X_JMBind.translation, glm::dvec3(-0.002, 0, 0)), 1e-9);
  const VisualPrimitive& primitive = mesh->primitives.at(0);
  EXPECT_EQ(primitive.positions[1], glm::vec3(0.001f, 0, 0)) << "the pose of a skin's own node does not count";
  EXPECT_EQ(primitive.joints[1].x, 1);
  EXPECT_EQ(primitive.weights[2], glm::vec4(0.25f, 0.75f, 0, 0));
}

TEST_F(GltfTest, ASkinThatCannotBeBentIsRefusedWithItsReason) {
  const auto why = [&](const char* joint) { return LoadSkin(joint).error().detail; };
  EXPECT_NE(why(R"({"name":"tip","scale":[1,2,1]})").find("joint 'tip' of its skin stretches"), std::string::npos);
  const char* good = R"({"name":"tip"})";
  ASSERT_TRUE(LoadSkin(good));
  weights_[4] = 0.2f;
  EXPECT_NE(why(good).find("the weights of vertex 1 do not add up to 1"), std::string::npos);
  weights_[4] = 1.0f;
  bind_[17] = 1.0f;  // a shear
  EXPECT_NE(why(good).find("joint 'tip' of its skin stretches"), std::string::npos);
}

TEST_F(GltfTest, MaterialsHaveLightOfTheirOwnLacquerAndVariants) {
  const auto mesh =
      Load(R"({"mesh":0})",
           R"(},"material":0,"extensions":{"KHR_materials_variants":{"mappings":[{"material":1,"variants":[0,2]}]}})",
           R"(,"extensionsUsed":["KHR_materials_variants"],
         "extensions":{"KHR_materials_variants":{"variants":[{"name":"lit"},{"name":"dark"},{"name":"test"}]}},
         "materials":[
           {"name":"plain","extensions":{"KHR_materials_clearcoat":{"clearcoatFactor":0.5,"clearcoatRoughnessFactor":0.25}}},
           {"name":"lens","emissiveFactor":[1,0.5,0],
            "extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":4}}}])");
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_EQ(mesh->variants, (std::vector<std::string>{"lit", "dark", "test"}));
  const VisualPrimitive& primitive = mesh->primitives.at(0);
  EXPECT_EQ(primitive.coat, 0.5f);
  EXPECT_EQ(primitive.coat_roughness, 0.25f);
  EXPECT_EQ(primitive.emissive, glm::vec3(0));
  ASSERT_EQ(primitive.variants.size(), 3u);
  for (const std::size_t lit : {0u, 2u}) {
    EXPECT_EQ(primitive.variants[lit].emissive, glm::vec3(4, 2, 0));
    EXPECT_TRUE(primitive.variants[lit].is_lens);
    EXPECT_EQ(primitive.variants[lit].coat, 0.0f);
  }
  EXPECT_EQ(primitive.variants[1].coat, 0.5f) << "a variant without a mapping has the first look";
}

TEST_F(GltfTest, GlassSaysHowMuchGoesThroughItAndHowStronglyItBends) {
  const auto glass = Load(R"({"mesh":0})", R"(},"material":0)",
                          R"(,"materials":[{"name":"glass","extensions":{
                             "KHR_materials_transmission":{"transmissionFactor":0.75},"KHR_materials_ior":{"ior":1.25}}}])");
  ASSERT_TRUE(glass) << glass.error().detail;
  EXPECT_EQ(glass->primitives.at(0).transmission, 0.75f);
  EXPECT_EQ(glass->primitives.at(0).ior, 1.25f);
  const auto paint = Load(R"({"mesh":0})", R"(},"material":0)", R"(,"materials":[{"name":"paint"}])");
  ASSERT_TRUE(paint) << paint.error().detail;
  EXPECT_EQ(paint->primitives.at(0).transmission, 0.0f);
}

}  // namespace
}  // namespace vps
