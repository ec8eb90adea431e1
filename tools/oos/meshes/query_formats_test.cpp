#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tools/oos/meshes/verbs.hpp"
#include "vps/testing/shapes.hpp"

namespace oos {
namespace {

namespace fs = std::filesystem;

void WriteObj(const fs::path& file, const vps::TriangleMesh& mesh) {
  std::ofstream out(file);
  for (const auto& v : mesh.vertices) out << "v " << v.x << ' ' << v.y << ' ' << v.z << '\n';
  for (const auto& t : mesh.triangles) out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
}

void WriteStl(const fs::path& file, const vps::TriangleMesh& mesh) {
  std::ofstream out(file);
  out << "solid part\n";
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    out << "facet normal 0 0 0\nouter loop\n";
    for (const auto& c : mesh.corners(i)) out << "vertex " << c.x << ' ' << c.y << ' ' << c.z << '\n';
    out << "endloop\nendfacet\n";
  }
  out << "endsolid part\n";
}

void WriteOff(const fs::path& file, const vps::TriangleMesh& mesh) {
  std::ofstream out(file);
  out << "OFF\n" << mesh.vertices.size() << ' ' << mesh.triangles.size() << " 0\n";
  for (const auto& v : mesh.vertices) out << v.x << ' ' << v.y << ' ' << v.z << '\n';
  for (const auto& t : mesh.triangles) out << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
}

void WritePly(const fs::path& file, const vps::TriangleMesh& mesh) {
  std::ofstream out(file);
  out << "ply\nformat ascii 1.0\nelement vertex " << mesh.vertices.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << mesh.triangles.size()
      << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const auto& v : mesh.vertices) out << v.x << ' ' << v.y << ' ' << v.z << '\n';
  for (const auto& t : mesh.triangles) out << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
}

// Binary glTF: header, JSON chunk, binary chunk.
void WriteGlb(const fs::path& file, const vps::TriangleMesh& mesh) {
  std::string data;
  const auto put = [](std::string* to, auto value) {
    char bytes[sizeof(value)];
    std::memcpy(bytes, &value, sizeof(value));
    to->append(bytes, sizeof(value));
  };
  for (const auto& t : mesh.triangles) {
    for (const auto v : t) put(&data, static_cast<std::uint32_t>(v));
  }
  const std::size_t index_bytes = data.size();
  glm::dvec3 low(1e9), high(-1e9);
  for (const auto& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k) put(&data, static_cast<float>(v[k]));
    low = glm::min(low, v);
    high = glm::max(high, v);
  }
  std::ostringstream json;
  json << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
       << R"("meshes":[{"primitives":[{"attributes":{"POSITION":1},"indices":0}]}],)"
       << R"("buffers":[{"byteLength":)" << data.size() << R"(}],"bufferViews":[{"buffer":0,"byteLength":)"
       << index_bytes << R"(},{"buffer":0,"byteOffset":)" << index_bytes << R"(,"byteLength":)"
       << data.size() - index_bytes
       << R"(}],"accessors":[{"bufferView":0,"componentType":5125,"type":"SCALAR","count":)" << index_bytes / 4
       << R"(},{"bufferView":1,"componentType":5126,"type":"VEC3","count":)" << mesh.vertices.size() << R"(,"min":[)"
       << low.x << ',' << low.y << ',' << low.z << R"(],"max":[)" << high.x << ',' << high.y << ',' << high.z << "]}]}";
  std::string text = json.str();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string all = "glTF";
  put(&all, std::uint32_t{2});
  put(&all, static_cast<std::uint32_t>(12 + 8 + text.size() + 8 + data.size()));
  put(&all, static_cast<std::uint32_t>(text.size()));
  put(&all, std::uint32_t{0x4E4F534A});  // JSON
  all += text;
  put(&all, static_cast<std::uint32_t>(data.size()));
  put(&all, std::uint32_t{0x004E4942});  // BIN
  all += data;
  std::ofstream(file, std::ios::binary) << all;
}

std::string LastRow(const fs::path& file) {
  std::ifstream stream(file);
  std::string line, last;
  while (std::getline(stream, line)) last = line;
  return last;
}

// The same box in five formats gives the same answer: distance, force, moment.
TEST(QueryFormats, GiveTheSameAnswer) {
  const fs::path folder = fs::path(testing::TempDir()) / "oos_query_formats";
  fs::remove_all(folder);
  fs::create_directories(folder);
  const vps::TriangleMesh box = vps::MakeBox({0.04, 0.04, 0.02});
  WriteObj(folder / "box.obj", box);
  WriteStl(folder / "box.stl", box);
  WritePly(folder / "box.ply", box);
  WriteOff(folder / "box.off", box);
  WriteGlb(folder / "box.glb", box);
  const std::string poses = (folder / "poses.csv").string();
  std::ofstream(poses) << "0.01,0.005,0.0195,1,0,0,0\n";
  const std::string out = (folder / "out.csv").string();
  for (const char* method : {"paper", "fast", "oracle"}) {
    std::string first;
    for (const char* file : {"box.obj", "box.stl", "box.ply", "box.off", "box.glb"}) {
      const std::string mesh = (folder / file).string();
      ASSERT_EQ(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()},
                         {"query", mesh, mesh, "--poses", poses, "--out", out, "--method", method, "--voxel_m", "0.001",
                          "--points", "2000"}),
                0)
          << method << ' ' << file;
      double now[7], was[7];
      std::string row = LastRow(out);
      std::replace(row.begin(), row.end(), ',', ' ');
      if (first.empty()) first = row;
      std::istringstream a(row), b(first);
      for (int k = 0; k < 7; ++k) {
        a >> now[k];
        b >> was[k];
      }
      // Corners may come in another order, and points with them.
      for (int k = 0; k < 7; ++k) {
        const double size = k == 0 ? std::abs(was[0]) : k < 4 ? std::abs(was[3]) : 0.04 * std::abs(was[3]);
        EXPECT_NEAR(now[k], was[k], 0.05 * size) << method << ' ' << file << ' ' << k;
      }
      EXPECT_LT(now[0], 0.0) << file;
      EXPECT_GT(now[3], 0.0) << file;
    }
  }
}

TEST(QueryFormats, AFailedQueryKeepsTheOldResults) {
  const fs::path folder = fs::path(testing::TempDir()) / "oos_query_kept";
  fs::remove_all(folder);
  fs::create_directories(folder);
  WriteObj(folder / "box.obj", vps::MakeBox({0.04, 0.04, 0.02}));
  std::ofstream(folder / "poses.csv") << "0,0,1,1,0,0,0\n0,0,1,1,0,0\n";
  std::ofstream(folder / "out.csv") << "old\n";
  const std::string mesh = (folder / "box.obj").string();
  testing::internal::CaptureStderr();
  EXPECT_NE(RunVerbs({CookVerb(), InspectVerb(), QueryVerb()},
                     {"query", mesh, mesh, "--poses", (folder / "poses.csv").string(), "--out",
                      (folder / "out.csv").string()}),
            0);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("poses.csv:2:"), std::string::npos);
  EXPECT_EQ(LastRow(folder / "out.csv"), "old");
}

}  // namespace
}  // namespace oos
