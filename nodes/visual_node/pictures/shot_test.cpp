#include "nodes/visual_node/pictures/shot.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "nodes/visual_node/testing/gl_test.hpp"
#include "nodes/visual_node/testing/read_png.hpp"
#include "picture/measured.hpp"
#include "scene/load_scenario.hpp"
#include "view/scene_mirror.hpp"

namespace visual_node {
namespace {

picture::Measured<float> ReadPfm(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string kind;
  int width = 0, height = 0;
  double scale = 0.0;
  in >> kind >> width >> height >> scale;
  in.get();
  EXPECT_EQ(scale, -1.0);
  picture::Measured<float> image(width, height, kind == "PF" ? 3 : 1);
  const std::size_t row = static_cast<std::size_t>(width * image.channels);
  for (int y = height - 1; y >= 0; --y) {
    in.read(reinterpret_cast<char*>(&image.values[row * static_cast<std::size_t>(y)]),
            static_cast<std::streamsize>(row * sizeof(float)));
  }
  EXPECT_TRUE(in);
  return image;
}

class ShotTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    auto scenario = scene::LoadScenario(VR_OOS_SOURCE_DIR "/scenarios/touch");
    ASSERT_TRUE(scenario);
    options_.width = 160;
    options_.height = 90;
    options_.pictures.shot = folder_ / "shot.png";
    options_.pictures.hdr = folder_ / "light.pfm";
    options_.pictures.depth = folder_ / "depth.pfm";
    options_.pictures.ids = folder_ / "ids.png";
    scenario_ = *scenario;
  }
  ~ShotTest() override { std::filesystem::remove_all(folder_); }

  void Take() {
    const view::SceneMirror mirror(scenario_);
    auto renderer =
        Renderer::Create(mirror.scene(), [](const std::filesystem::path& file) { return vps::LoadVisualMesh(file); });
    ASSERT_TRUE(renderer) << renderer.error().detail;
    const auto done = TakeShot(options_, mirror.scene(), renderer->get());
    ASSERT_TRUE(done) << done.error().detail;
  }

  scene::Scenario scenario_;
  Options options_;
  const std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("shot_" + std::to_string(getpid()));
};

TEST_F(ShotTest, TheLightIsThatOfThePicture) {
  Take();
  const picture::Image shot = ReadPng(options_.pictures.shot);
  const picture::Measured<float> light = ReadPfm(options_.pictures.hdr);
  const picture::Measured<float> depth_m = ReadPfm(options_.pictures.depth);
  ASSERT_EQ(light.channels, 3);
  ASSERT_EQ(shot.width, light.width);
  // Of two pixels of objects in the lower half, where no text is, the much brighter one is the brighter one in both.
  struct Pixel {
    float light = 0.0f;
    int shown = 0;
  };
  std::vector<Pixel> pixels;
  for (int y = shot.height / 2; y < shot.height * 3 / 4; y += 3) {
    for (int x = 0; x < shot.width; x += 3) {
      if (*depth_m.Pixel(x, y) == 0.0f) continue;
      const float* l = light.Pixel(x, y);
      const std::uint8_t* c = shot.Pixel(x, y);
      pixels.push_back({0.25f * l[0] + 0.625f * l[1] + 0.125f * l[2], (2 * c[0] + 5 * c[1] + c[2]) / 8});
    }
  }
  ASSERT_GT(pixels.size(), 100U);
  int num_pairs = 0;
  for (const Pixel& a : pixels) {
    for (const Pixel& b : pixels) {
      if (a.light < 2.0f * b.light + 0.05f) continue;
      EXPECT_GT(a.shown, b.shown) << a.light << " " << b.light;
      ++num_pairs;
    }
  }
  EXPECT_GT(num_pairs, 100);
}

TEST_F(ShotTest, EveryWantedFileIsWrittenAndTheIdsAreNamed) {
  Take();
  for (const char* file : {"shot.png", "light.pfm", "depth.pfm", "ids.png", "ids.json"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_ / file)) << file;
  }
}

}  // namespace
}  // namespace visual_node
