// Compares pictures of the page with those of the OpenGL renderer, for the page's tests. Reads a line for each picture
// from standard input, VIEW WIDTH HEIGHT PAGE.png PAGE.ids (u16 from the upper left corner), and answers with a line of
// JSON.

#include <fstream>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "nodes/run_node/command_line.hpp"
#include "nodes/visual_node/camera_feed.hpp"
#include "nodes/visual_node/draw/composer.hpp"
#include "nodes/visual_node/draw/object_pass.hpp"
#include "nodes/visual_node/options.hpp"
#include "nodes/visual_node/pictures/offline.hpp"
#include "nodes/visual_node/pictures/shot.hpp"
#include "view/choices.hpp"
#include "view/conformance/compare.hpp"

namespace {

constexpr const char* kProgram = "page_compare";

cli::Syntax Syntax() {
  cli::Syntax syntax;
  syntax.program = kProgram;
  syntax.summary = "compares pictures of the page with those of the OpenGL renderer";
  syntax.options = {{"--scenario", "FILE", "what is shown"},
                    {"--recording", "FILE.mcap", "default: the scenario as it begins"},
                    {"--at", "S", "of the recording", "0"},
                    {"--show", "LIST", "overlays and more"},
                    {"--keep", "DIR", "write the OpenGL renderer's pictures there"}};
  return syntax;
}

std::vector<char> ReadFile(const std::string& name) {
  std::ifstream file(name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

core::Result<view::Rendering> ReadPage(const std::string& png, const std::string& ids, int width, int height) {
  const std::vector<char> bytes = ReadFile(png), numbers = ReadFile(ids);
  auto image = picture::ReadPng(std::as_bytes(std::span(bytes)));
  if (!image) return tl::unexpected(image.error());
  view::Rendering page{std::move(*image), {width, height}};
  const std::size_t size = page.ids.values.size() * sizeof(std::uint16_t);
  if (page.image.width != width || page.image.height != height || numbers.size() != size) {
    return core::Fail(core::ErrorCode::kDamaged,
                      png + ", " + ids + ": not " + std::to_string(width) + "x" + std::to_string(height) + " pixels");
  }
  std::memcpy(page.ids.values.data(), numbers.data(), size);
  return page;
}

core::Result<view::Rendering> DrawByGl(const visual_node::Offline& offline, const view::Scene& scene,
                                       const view::Choices& choices, const scene::Camera& camera, int width,
                                       int height) {
  constexpr int kSamples = visual_node::kSmoothSamples;
  const visual_node::RenderTarget target(kSamples * width, kSamples * height);
  if (auto drawn = offline.renderer->Draw(scene, camera, target); !drawn) return tl::unexpected(drawn.error());
  auto added = visual_node::AddInset(*offline.renderer, scene, choices, view::Stereo::kNone, target);
  if (!added) return tl::unexpected(added.error());
  const auto pass = visual_node::ObjectPass::Create();
  if (!pass) return tl::unexpected(pass.error());
  return view::Rendering{picture::Shrink(target.Read(), kSamples),
                         pass->Draw(*offline.renderer, scene, camera, width, height).ids};
}

core::Result<void> CompareAll(const cli::Arguments& arguments, const scene::Scenario& scenario) {
  visual_node::Options options;
  options.show = arguments.text("--show");
  options.pictures.recording = arguments.text("--recording");
  if (!options.pictures.recording.empty()) options.pictures.at_s = std::stod(arguments.text("--at"));
  auto scene = visual_node::SceneOf(options, scenario);
  if (!scene) return tl::unexpected(scene.error());
  const auto choices = view::ReadChoices(options.show, scene->assets->instance_names);
  if (!choices) return tl::unexpected(choices.error());
  // The page's letters are the browser's.
  scene->texts.clear();
  scene->labels.clear();
  scene->graphs.clear();
  const auto offline = visual_node::Offline::Create(scenario, "");
  if (!offline) return tl::unexpected(offline.error());
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    std::string png, ids;
    scene::Camera camera;
    int width = 0, height = 0;
    words >> camera.name >> camera.eye_m.x >> camera.eye_m.y >> camera.eye_m.z >> camera.target_m.x >>
        camera.target_m.y >> camera.target_m.z >> camera.vertical_fov_rad >> width >> height >> png >> ids;
    const auto page = ReadPage(png, ids, width, height);
    if (!page) return tl::unexpected(page.error());
    const auto gl = DrawByGl(*offline, *scene, *choices, camera, width, height);
    if (!gl) return tl::unexpected(gl.error());
    if (arguments.has("--keep")) {
      auto kept =
          picture::WritePng(gl->image, std::filesystem::path(arguments.text("--keep")) / (camera.name + ".png"));
      if (!kept) return kept;
    }
    const view::Agreement agreement = view::Compare(*gl, *page);
    std::cout << nlohmann::json{{"view", camera.name},
                                {"flip", agreement.flip},
                                {"same_ids", agreement.same_ids},
                                {"same_ids_inside", agreement.same_ids_inside}}
              << std::endl;
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  int status = run_node::kDone;
  const auto arguments = run_node::ReadCommandLine(argc, argv, Syntax(), &status);
  if (!arguments) return status;
  const auto scenario = run_node::ReadScenario(kProgram, arguments->text("--scenario"));
  if (!scenario) return run_node::kBadUsage;
  const auto done = CompareAll(*arguments, *scenario);
  return done ? run_node::kDone : run_node::Report(kProgram, done.error().detail, run_node::kFailed);
}
