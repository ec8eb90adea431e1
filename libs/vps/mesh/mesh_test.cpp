#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <thread>

#include "vps/mesh/load_mesh.hpp"
#include "vps/mesh/mass_properties.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

std::filesystem::path Write(const std::string& name, const std::string& text) {
  const auto file = std::filesystem::path(testing::TempDir()) / ("vps_" + name);
  std::ofstream(file, std::ios::binary) << text;
  return file;
}

constexpr const char* kTetrahedronObj =
    "# tetrahedron\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

TEST(LoadMesh, ReadsObjAndScalesIt) {
  const auto mesh = LoadMesh(Write("tetra.obj", kTetrahedronObj), 0.001);
  ASSERT_TRUE(mesh.has_value()) << mesh.error().detail;
  EXPECT_EQ(mesh->vertices.size(), 4U);
  EXPECT_EQ(mesh->triangles.size(), 4U);
  EXPECT_NEAR(BoundingBox(*mesh).upper.x, 0.001, 1e-9);
  EXPECT_EQ(CountOpenEdges(*mesh), 0U);
}

// OpenMesh keeps the folder of the file that it reads in a reader that all files of one format share.
TEST(LoadMesh, ReadsOnFourThreadsAtOnce) {
  constexpr int kTimes = 2000;
  std::filesystem::create_directories(std::filesystem::path(testing::TempDir()) / "vps_folder_with_a_name_on_the_heap");
  const std::filesystem::path file = Write("folder_with_a_name_on_the_heap/tetra.obj", kTetrahedronObj);
  std::vector<int> num_read(4, 0);
  std::vector<std::thread> threads;
  for (int& n : num_read) {
    threads.emplace_back([&n, &file] {
      for (int i = 0; i < kTimes; ++i) {
        const auto mesh = LoadMesh(file, 0.001);
        n += mesh.has_value() && mesh->triangles.size() == 4U ? 1 : 0;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(num_read, std::vector<int>(4, kTimes));
}

TEST(LoadMesh, MergesTheRepeatedCornersOfStl) {
  std::string text = "solid t\n";
  const auto box = MakeBox({1, 2, 3});
  for (std::size_t i = 0; i < box.triangles.size(); ++i) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const auto& p : box.corners(i)) {
      text += "vertex " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
    }
    text += "endloop\nendfacet\n";
  }
  const auto mesh = LoadMesh(Write("box.stl", text + "endsolid t\n"));
  ASSERT_TRUE(mesh.has_value()) << mesh.error().detail;
  EXPECT_EQ(mesh->vertices.size(), 8U);
  EXPECT_EQ(mesh->triangles.size(), 12U);
  EXPECT_EQ(CountOpenEdges(*mesh), 0U);
}

TEST(LoadMesh, ReadsPlyAndOff) {
  const auto ply =
      LoadMesh(Write("t.ply",
                     "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
                     "float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 "
                     "0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"));
  ASSERT_TRUE(ply.has_value()) << ply.error().detail;
  EXPECT_EQ(ply->triangles.size(), 4U);
  const auto off =
      LoadMesh(Write("t.off", "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"));
  ASSERT_TRUE(off.has_value()) << off.error().detail;
  EXPECT_EQ(CountOpenEdges(*off), 0U);
}

TEST(LoadMesh, AppliesTheNodeTransformsOfGltf) {
  // One triangle (0,0,0) (1,0,0) (0,1,0), moved by a parent and scaled by a child node.
  const auto file = Write("t.gltf", R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
    "nodes":[{"children":[1],"translation":[10,0,0]},{"mesh":0,"scale":[2,2,2]}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
    "materials":[{"name":"mli_gold","pbrMetallicRoughness":{"baseColorFactor":[0.1,0.2,0.3,1],"metallicFactor":0.9,"roughnessFactor":0.4}}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
    "bufferViews":[{"buffer":0,"byteLength":36}],
    "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})");
  const auto mesh = LoadMesh(file);
  ASSERT_TRUE(mesh.has_value()) << mesh.error().detail;
  EXPECT_NEAR(BoundingBox(*mesh).lower.x, 10.0, 1e-6);
  EXPECT_NEAR(BoundingBox(*mesh).upper.x, 12.0, 1e-6);
  const auto visual = LoadVisualMesh(file);
  ASSERT_TRUE(visual.has_value()) << visual.error().detail;
  ASSERT_EQ(visual->primitives.size(), 1U);
  EXPECT_TRUE(visual->primitives[0].has_material);
  EXPECT_TRUE(visual->primitives[0].is_foil);
  EXPECT_FLOAT_EQ(visual->primitives[0].metallic, 0.9f);
  EXPECT_NEAR(visual->primitives[0].normals[0].z, 1.0f, 1e-6f);
}

TEST(LoadMesh, NamesFileAndCause) {
  EXPECT_EQ(LoadMesh("/nowhere/a.obj").error().code, core::ErrorCode::kNotFound);
  EXPECT_EQ(LoadMesh(Write("a.step", "x")).error().code, core::ErrorCode::kUnsupported);
  EXPECT_NE(LoadMesh(Write("empty.obj", "v 0 0 0\n")).error().detail.find("empty.obj"), std::string::npos);
  EXPECT_FALSE(LoadMesh(Write("bad.gltf", "{\"asset\":")).has_value());
  EXPECT_FALSE(LoadMesh(Write("nan.off", "OFF\n3 1 0\nnan 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")).has_value());
  EXPECT_FALSE(LoadMesh(Write("far.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")).has_value());
}

TEST(LoadMesh, NamesTheLineOfANonFiniteCorner) {
  // Readers of these formats skip such a corner silently and shift all that follow.
  const std::pair<const char*, const char*> files[] = {
      {"nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nv 0 0 1\nv 5 5 5\nf 1 2 3\n"},
      {"word.obj", "v 0 0 0\nv 1,5 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\n"},
      {"huge.obj", "v 0 0 0\nv 1e999 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\n"},
      {"short.obj", "v 0 0 0\nv 1 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\n"},
      {"inf.off", "OFF\ninf 0 0\n"},
      {"nan.stl", "solid nan\nvertex nan 0 0\n"},
      {"inf.ply", "ply\n0 -inf 0\n"},
  };
  for (const auto& [name, text] : files) {
    const auto mesh = LoadMesh(Write(name, text));
    ASSERT_FALSE(mesh.has_value()) << name;
    EXPECT_NE(mesh.error().detail.find(std::string(name) + ":2: a corner is not a finite number"), std::string::npos)
        << mesh.error().detail;
  }
}

TEST(LoadVisualMesh, KeepsBoxEdgesSharp) {
  const auto box = MakeBox({1, 1, 1});
  std::string text;
  for (const auto& p : box.vertices) {
    text += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
  }
  for (const auto& t : box.triangles) {
    text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " + std::to_string(t[2] + 1) + "\n";
  }
  const auto visual = LoadVisualMesh(Write("box.obj", text));
  ASSERT_TRUE(visual.has_value());
  EXPECT_EQ(visual->primitives[0].positions.size(), 24U);
}

TEST(MassProperties, OfABoxAreExactWhereverItStands) {
  auto box = MakeBox({0.1, 0.2, 0.3});
  for (auto& p : box.vertices) p += glm::dvec3(5, -3, 2);
  const auto m = ComputeMassProperties(box, 2700.0);
  ASSERT_TRUE(m.has_value());
  EXPECT_NEAR(m->mass_kg, 16.2, 1e-10);
  EXPECT_NEAR(glm::length(m->p_OCom_m - glm::dvec3(5, -3, 2)), 0.0, 1e-12);
  EXPECT_NEAR(m->inertia_Com_kg_m2[0][0], 16.2 / 12 * (0.04 + 0.09), 1e-10);
  EXPECT_NEAR(m->inertia_Com_kg_m2[1][1], 16.2 / 12 * (0.01 + 0.09), 1e-10);
  EXPECT_NEAR(m->inertia_Com_kg_m2[0][1], 0.0, 1e-12);
}

TEST(MassProperties, OfATorusApproachTheClosedForm) {
  const double R = 0.1, r = 0.04;
  const auto m = ComputeMassProperties(MakeTorus(R, r, 512, 256), 1000.0);
  ASSERT_TRUE(m.has_value());
  const double mass = 1000.0 * 2 * std::numbers::pi * std::numbers::pi * R * r * r;
  EXPECT_NEAR(m->mass_kg, mass, 2e-4 * mass);
  EXPECT_NEAR(m->inertia_Com_kg_m2[2][2], mass * (R * R + 0.75 * r * r), 3e-4 * mass * R * R);
}

TEST(MassProperties, RefuseOpenAndInsideOutMeshes) {
  auto open = MakeBox({1, 1, 1});
  open.triangles.pop_back();
  EXPECT_FALSE(ComputeMassProperties(open, 1.0).has_value());
  auto inside_out = MakeBox({1, 1, 1});
  for (auto& t : inside_out.triangles) std::swap(t[1], t[2]);
  EXPECT_NE(ComputeMassProperties(inside_out, 1.0).error().detail.find("inside out"), std::string::npos);
}

TEST(Shapes, AreClosedAndOutward) {
  for (const auto& mesh : {MakeBox({1, 2, 3}), MakeSphere(1, 24), MakeTorus(1, 0.3, 24, 12), MakeCylinder(1, 2, 24),
                           MakeBlockWithHole(3, 1, 1, 24)}) {
    EXPECT_EQ(CountOpenEdges(mesh), 0U);
    EXPECT_TRUE(ComputeMassProperties(mesh, 1.0).has_value());
  }
}

}  // namespace
}  // namespace vps
