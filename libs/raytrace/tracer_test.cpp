#include "raytrace/tracer.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "view/conformance/cast_ids.hpp"
#include "view/conformance/testing/known_scene.hpp"
#include "vps/mesh/vertex_normals.hpp"
#include "vps/testing/shapes.hpp"

namespace raytrace {
namespace {

constexpr int kWidth = 320, kHeight = 180;
constexpr Tile kWhole{0, 0, kWidth, kHeight};

std::unique_ptr<Tracer> Trace(const view::Scene& scene, const MeshLoader& load_mesh = view::MeshOfBody) {
  auto tracer = Tracer::Create(scene, load_mesh);
  EXPECT_TRUE(tracer) << tracer.error().detail;
  (*tracer)->Update(scene, view::LightOf(scene.space));
  return std::move(*tracer);
}

glm::vec3 LightAt(const LitTile& lit, int x, int y) {
  const float* light = lit.light.Pixel(x, y);
  return {light[0], light[1], light[2]};
}

// A box on a floor, in the sun alone, from 4 m above: x of the world to the right, y upwards in the picture.
struct BoxOnFloor {
  static constexpr double kHigh_m = 0.5, kSide_m = 0.4;

  view::Scene scene = view::KnownScene();
  view::EnvironmentLight light{.sun_direction_W = glm::normalize(glm::vec3(-0.3f, 0.0f, 0.8f)), .sun = glm::vec3(3.0f)};
  scene::Camera camera;

  BoxOnFloor() {
    scene.instances.resize(2);
    scene.instances[0].X_WM = {};
    scene.instances[1].X_WM = {};
    scene.instances[1].X_WM.translation.z = 0.5 * kHigh_m;
    camera.eye_m = {0.0, 0.0, 4.0};
    camera.target_m = {0.0, 0.0, 0.0};
    camera.vertical_fov_rad = 0.5;
  }
  static core::Result<vps::VisualMesh> Mesh(const std::filesystem::path& name) {
    const glm::dvec3 size = name == "0" ? glm::dvec3(4, 4, 1e-6) : glm::dvec3(kSide_m, kSide_m, kHigh_m);
    return vps::VisualMesh{{vps::SplitAtCreases(vps::MakeBox(size), 0.6)}};
  }
};

TEST(Tracer, EachPixelShowsTheObjectThatItsRayMeets) {
  const view::Scene scene = view::KnownScene();
  const auto exact = view::CastIds(view::KnownBodies(), view::KnownCamera(), kWidth, kHeight);
  const ObjectTile found = Trace(scene)->FindObjects(Eye::Of(view::KnownCamera(), kWidth, kHeight), kWhole);
  int same = 0;
  for (std::size_t i = 0; i < exact.values.size(); ++i) same += exact.values[i] == found.ids.values[i] ? 1 : 0;
  const double share = static_cast<double>(same) / static_cast<double>(exact.values.size());
  RecordProperty("same_ids", std::to_string(share));
  EXPECT_GE(share, 0.995);
}

TEST(Tracer, TheDepthIsAlongTheViewingDirection) {
  const BoxOnFloor box;
  const ObjectTile found =
      Trace(box.scene, BoxOnFloor::Mesh)->FindObjects(Eye::Of(box.camera, kWidth, kHeight), kWhole);
  EXPECT_NEAR(*found.depth_m.Pixel(kWidth / 2, kHeight / 2), 4.0 - BoxOnFloor::kHigh_m, 1e-5);
  EXPECT_NEAR(*found.depth_m.Pixel(2, 2), 4.0, 1e-5);
}

TEST(Tracer, ATileIsThatPartOfThePicture) {
  const auto tracer = Trace(view::KnownScene());
  const Eye eye = Eye::Of(view::KnownCamera(), kWidth, kHeight);
  const Tile at{117, 61, 53, 38};  // no multiple of anything
  const LitTile whole = tracer->Draw(eye, kWhole), part = tracer->Draw(eye, at);
  for (int y = 0; y < at.height; ++y) {
    for (int x = 0; x < at.width; ++x) {
      EXPECT_LT(glm::distance(LightAt(part, x, y), LightAt(whole, at.x + x, at.y + y)), 1e-4f) << x << " " << y;
    }
  }
}

// White balls in uniform light are invisible: whatever the material, they reflect all that they get.
TEST(Tracer, AWhiteFurnaceLosesNoEnergyAtAnyRoughness) {
  view::Scene scene = view::KnownScene();
  for (view::Instance& instance : scene.instances) instance.is_visible = false;
  view::Instance& ball = scene.instances[1];
  ball.is_visible = true;
  ball.material.base_color = glm::vec3(1.0f);
  const auto tracer = Trace(scene);
  const view::EnvironmentLight furnace{.everywhere = glm::vec3(1.0f)};
  for (const float metallic : {0.0f, 0.5f, 1.0f}) {
    for (const float roughness : {0.1f, 0.5f, 1.0f}) {
      ball.material.metallic = metallic;
      ball.material.roughness = roughness;
      tracer->Update(scene, furnace);
      const LitTile lit = tracer->Draw(Eye::Of(view::KnownCamera(), kWidth, kHeight), kWhole);
      int count = 0;
      for (std::size_t i = 0; i < lit.depth_m.values.size(); ++i) {
        if (lit.depth_m.values[i] == 0.0f) continue;
        ++count;
        EXPECT_NEAR(lit.light.values[3 * i + 1], 1.0f, 0.02f) << metallic << " " << roughness;
      }
      EXPECT_GT(count, 500);
    }
  }
}

TEST(Tracer, AMattFloorUnderTheSunHasLambertsRadiance) {
  BoxOnFloor box;
  box.scene.instances[1].is_visible = false;
  view::Material& floor = box.scene.instances[0].material;
  floor.roughness = 1.0f;
  const auto tracer = Trace(box.scene, BoxOnFloor::Mesh);
  const auto radiance = [&](float albedo) {
    floor.base_color = glm::vec3(albedo);
    tracer->Update(box.scene, box.light);
    return LightAt(tracer->Draw(Eye::Of(box.camera, kWidth, kHeight), kWhole), kWidth / 2, kHeight / 2).g;
  };
  // What a rough dielectric mirrors is the same for both, and at most 4 % of the light: the ground gets the rest.
  const float matt = radiance(0.5f) - radiance(0.0f);
  const float lambert = 0.5f * 3.0f * box.light.sun_direction_W.z / std::acos(-1.0f);
  EXPECT_LT(matt, lambert);
  EXPECT_GT(matt, 0.96f * lambert);
}

TEST(Tracer, TheShadowOfABoxEndsWhereTheSunsRayOverItsEdgeMeetsTheFloor) {
  const BoxOnFloor box;
  const auto tracer = Trace(box.scene, BoxOnFloor::Mesh);
  tracer->Update(box.scene, box.light);
  constexpr int kSize = 800;
  const Eye eye = Eye::Of(box.camera, kSize, kSize);
  const LitTile row = tracer->Draw(eye, {0, kSize / 2, kSize, 4});
  const double pixel_m = 4.0 * eye.pixel().y;
  // The camera looks down along z, so its up is y and x is to the right.
  const double end_m = 0.5 * BoxOnFloor::kSide_m + BoxOnFloor::kHigh_m * 0.3 / 0.8;
  const int end_px = static_cast<int>(std::floor(0.5 * kSize + end_m / pixel_m));
  EXPECT_GT(LightAt(row, end_px + 1, 0).g, 0.1f);
  EXPECT_EQ(LightAt(row, end_px - 1, 0).g, 0.0f);
}

TEST(Tracer, WhatMovesNeedsNoNewTreeOfTriangles) {
  BoxOnFloor box;
  const auto tracer = Trace(box.scene, BoxOnFloor::Mesh);
  const int before = tracer->world().num_mesh_builds();
  box.scene.instances[1].X_WM.translation.x = 0.6;
  tracer->Update(box.scene, box.light);
  const Eye eye = Eye::Of(box.camera, kWidth, kHeight);
  const ObjectTile found = tracer->FindObjects(eye, kWhole);
  EXPECT_EQ(*found.ids.Pixel(kWidth / 2, kHeight / 2), 1);
  EXPECT_EQ(*found.ids.Pixel(kWidth / 2 + static_cast<int>(0.6f / 4.0f / eye.pixel().x), kHeight / 2), 2);
  EXPECT_EQ(tracer->world().num_mesh_builds(), before);
}

TEST(Tracer, ATransparentObjectIsFoundButNotDrawnAndAHiddenOneIsNeither) {
  BoxOnFloor box;
  const auto tracer = Trace(box.scene, BoxOnFloor::Mesh);
  const Eye eye = Eye::Of(box.camera, kWidth, kHeight);
  const auto depth = [&] { return *tracer->Draw(eye, kWhole).depth_m.Pixel(kWidth / 2, kHeight / 2); };
  const auto id = [&] { return *tracer->FindObjects(eye, kWhole).ids.Pixel(kWidth / 2, kHeight / 2); };
  box.scene.instances[1].opacity = 0.5f;
  tracer->Update(box.scene, box.light);
  EXPECT_NEAR(depth(), 4.0f, 1e-5f);
  EXPECT_EQ(id(), 2);
  box.scene.instances[1].is_visible = false;
  tracer->Update(box.scene, box.light);
  EXPECT_NEAR(depth(), 4.0f, 1e-5f);
  EXPECT_EQ(id(), 1);
}

TEST(Tracer, AMirrorShowsWhatStandsBeforeItAndARoughMetalDoesNot) {
  BoxOnFloor box;
  box.light.everywhere = glm::vec3(0.2f);
  box.scene.instances[0].material = {.base_color = glm::vec3(0.9f), .metallic = 1.0f, .roughness = 0.1f};
  box.scene.instances[1].material = {.base_color = glm::vec3(0.0f), .emissive = {1.0f, 0.0f, 0.0f}};
  box.scene.instances[1].X_WM.translation.z = 1.0;
  box.camera.eye_m = {2.0, 0.0, 2.0};
  const auto tracer = Trace(box.scene, BoxOnFloor::Mesh);
  // Where the ray from the eye to the box's image, 1 m below the floor, meets the floor: at a third of the way up.
  const glm::dvec3 seen = glm::mix(glm::dvec3(0.0, 0.0, -1.0), box.camera.eye_m, 1.0 / 3.0);
  box.camera.target_m = seen;
  const auto light = [&] {
    tracer->Update(box.scene, box.light);
    return LightAt(tracer->Draw(Eye::Of(box.camera, kWidth, kHeight), kWhole), kWidth / 2, kHeight / 2);
  };
  const glm::vec3 mirrored = light();
  EXPECT_GT(mirrored.r, 4.0f * mirrored.g);
  box.scene.instances[0].material.roughness = 0.9f;
  const glm::vec3 blurred = light();
  EXPECT_LT(blurred.r, 1.2f * blurred.g);
}

TEST(Tracer, ASheetBendsWhereItsNodesAre) {
  BoxOnFloor box;
  view::Sheet sheet;
  sheet.instance = 1;
  sheet.num_columns = 3;
  for (int i = 0; i < 9; ++i)
    sheet.p_W.emplace_back(0.2f * static_cast<float>(i % 3 - 1), 0.2f * static_cast<float>(i / 3 - 1), 1.0f);
  box.scene.sheets = {sheet};
  const auto tracer = Trace(box.scene, BoxOnFloor::Mesh);
  const Eye eye = Eye::Of(box.camera, kWidth, kHeight);
  const auto depth = [&] { return *tracer->Draw(eye, kWhole).depth_m.Pixel(kWidth / 2, kHeight / 2); };
  EXPECT_NEAR(depth(), 3.0f, 1e-3f);
  EXPECT_EQ(*tracer->FindObjects(eye, kWhole).ids.Pixel(kWidth / 2, kHeight / 2), 2);
  for (glm::vec3& p : box.scene.sheets[0].p_W) p.z = 1.5f;
  box.scene.sheets[0].version = 1;
  tracer->Update(box.scene, box.light);
  EXPECT_NEAR(depth(), 2.5f, 1e-3f);
}

// A plate of glass, 0.2 m thick, over a floor that shines from x = 0 on, seen at 45 degrees. The plate shifts a ray
// sideways by t (tan a - tan b), with sin a = n sin b.
TEST(Tracer, GlassShiftsWhatIsBehindItBySnellsLaw) {
  BoxOnFloor box;
  box.light = {};
  box.scene.instances[0].material = {.base_color = glm::vec3(0.0f), .emissive = glm::vec3(1.0f)};
  box.scene.instances[0].X_WM.translation.x = 2.0;
  box.scene.instances[1].is_material_given = false;
  constexpr double kThick_m = 0.2;
  for (const double ior : {1.0, 1.33, 1.5}) {
    const auto mesh = [ior](const std::filesystem::path& name) -> core::Result<vps::VisualMesh> {
      if (name == "0") return BoxOnFloor::Mesh(name);
      vps::VisualPrimitive plate = vps::SplitAtCreases(vps::MakeBox({8, 8, kThick_m}), 0.6);
      plate.has_material = true;
      plate.base_color = glm::vec3(1.0f);
      plate.transmission = 1.0f;
      plate.ior = static_cast<float>(ior);
      return vps::VisualMesh{{plate}};
    };
    const double sine = std::sqrt(0.5) / ior;
    const double shift_m = kThick_m * (1.0 - sine / std::sqrt(1.0 - sine * sine));
    box.camera.target_m = {shift_m, 0.0, 0.0};  // where a straight ray would see it
    box.camera.eye_m = box.camera.target_m + glm::dvec3(-1.5, 0.0, 1.5);
    const auto tracer = Trace(box.scene, mesh);
    tracer->Update(box.scene, box.light);
    const LitTile lit = tracer->Draw(Eye::Of(box.camera, kWidth, kHeight), kWhole);
    int edge = kHeight;  // from the bottom upwards x grows
    while (edge > 0 && LightAt(lit, kWidth / 2, edge - 1).g < 0.5f) --edge;
    EXPECT_NEAR(edge, kHeight / 2, 1) << ior;
    const float seen = LightAt(lit, kWidth / 2, kHeight / 4).g;
    EXPECT_LT(seen, 1.1f) << "1.1 is what the floor sends";
    EXPECT_GT(seen, 0.85f) << "both faces mirror some";
  }
}

// A ball of glass over a floor that shines from x = 0.05 m on, seen from straight above: it shows the floor's edge
// where a ray that passes the ball's centre at the distance p, and is bent by 2 (a - b) with sin a = p / R = n sin b,
// comes down; behind the focus that is the other way round.
TEST(Tracer, ABallOfGlassIsALens) {
  BoxOnFloor box;
  constexpr double kRadius_m = 0.2, kDown_m = 0.6, kEdge_m = 0.05, kFar_m = 40.0;
  box.light = {};
  box.scene.instances[0].material = {.base_color = glm::vec3(0.0f), .emissive = glm::vec3(1.0f)};
  box.scene.instances[0].X_WM.translation.x = 2.0 + kEdge_m;
  box.scene.instances[1].X_WM.translation = {0.0, 0.0, kDown_m};
  box.scene.instances[1].is_material_given = false;
  box.camera.target_m = {0.0, 0.0, kDown_m};
  box.camera.eye_m = {0.0, 0.0, kDown_m + kFar_m};
  box.camera.vertical_fov_rad = 2.0 * std::atan(0.5 * 0.2 / kFar_m);
  const Eye eye = Eye::Of(box.camera, kWidth, kHeight);
  for (const double ior : {1.33, 1.5, 1.8}) {
    const auto tracer = Trace(box.scene, [&](const std::filesystem::path& name) -> core::Result<vps::VisualMesh> {
      if (name == "0") return BoxOnFloor::Mesh(name);
      vps::VisualPrimitive ball = vps::SplitAtCreases(vps::MakeSphere(kRadius_m, 256), 0.6);
      ball.has_material = true;
      ball.base_color = glm::vec3(1.0f);
      ball.transmission = 1.0f;
      ball.ior = static_cast<float>(ior);
      return vps::VisualMesh{{ball}};
    });
    tracer->Update(box.scene, box.light);
    const LitTile row = tracer->Draw(eye, {0, kHeight / 2, kWidth, 4});
    // Where the ray comes down, relative to the edge.
    const auto beyond_m = [&](double x_px) {
      const double outwards = std::atan((x_px - 0.5 * kWidth) * static_cast<double>(eye.pixel().x));
      const double p = kFar_m * std::sin(outwards), sine = p / kRadius_m;
      const double down = outwards - 2.0 * (std::asin(sine) - std::asin(sine / ior));
      return (p + kDown_m * std::sin(down)) / std::cos(down) - kEdge_m;
    };
    int compared = 0, shining = 0;
    for (int x = 0; x < kWidth; ++x) {
      // A pixel in which the edge is may be either.
      if ((beyond_m(x - 0.5) > 0.0) != (beyond_m(x + 1.5) > 0.0)) continue;
      ++compared;
      const bool shines = beyond_m(x + 0.5) > 0.0;
      shining += shines ? 1 : 0;
      EXPECT_EQ(LightAt(row, x, 0).g > 0.5f, shines) << ior << " " << x;
    }
    EXPECT_GT(compared, kWidth - 10) << ior;
    EXPECT_GT(shining, 20) << ior;
    EXPECT_LT(shining, kWidth - 20) << ior;
  }
}

TEST(Tracer, GlassCastsNoShadow) {
  BoxOnFloor box;
  box.scene.instances[1].is_material_given = false;
  const auto shaded = [&](float transmission) {
    const auto tracer = Trace(box.scene, [&](const std::filesystem::path& name) -> core::Result<vps::VisualMesh> {
      core::Result<vps::VisualMesh> mesh = BoxOnFloor::Mesh(name);
      mesh->primitives[0].transmission = transmission;
      return mesh;
    });
    tracer->Update(box.scene, box.light);
    box.camera.target_m = {0.3, 0.0, 0.0};
    box.camera.eye_m = {0.3, 0.0, 4.0};
    return LightAt(tracer->Draw(Eye::Of(box.camera, kWidth, kHeight), kWhole), kWidth / 2, kHeight / 2).g;
  };
  EXPECT_EQ(shaded(0.0f), 0.0f);
  EXPECT_GT(shaded(1.0f), 0.1f);
}

// The mean over the samples of a picture.
glm::vec3 Mean(const Tracer& tracer, const Eye& eye, int x, int y, std::uint32_t samples) {
  glm::vec3 sum(0.0f);
  for (std::uint32_t sample = 1; sample <= samples; ++sample) {
    sum += LightAt(tracer.Draw(eye, {x, y, 1, 1}, {tiles::Mirrors::kAll, sample}), 0, 0);
  }
  return sum / static_cast<float>(samples);
}

// From 0.5 m above the floor the sun's disc blurs an edge over 5 mm, here 24 pixels.
TEST(Tracer, SamplesOfTheSunBlurAShadowsEdge) {
  BoxOnFloor box;
  const double edge_m = 0.5 * BoxOnFloor::kSide_m + BoxOnFloor::kHigh_m * 0.3 / 0.8;
  box.camera.target_m = {edge_m, 0.0, 0.0};
  box.camera.eye_m = {edge_m, 0.0, 4.0};
  box.camera.vertical_fov_rad = 0.01;
  const auto tracer = Trace(box.scene, BoxOnFloor::Mesh);
  tracer->Update(box.scene, box.light);
  const Eye eye = Eye::Of(box.camera, kWidth, kHeight);
  const float full = Mean(*tracer, eye, kWidth / 2 + 40, kHeight / 2, 16).g;
  EXPECT_EQ(Mean(*tracer, eye, kWidth / 2 - 40, kHeight / 2, 16).g, 0.0f);
  EXPECT_NEAR(Mean(*tracer, eye, kWidth / 2, kHeight / 2, 64).g, 0.5f * full, 0.08f * full);
  const float hard = LightAt(tracer->Draw(eye, {kWidth / 2 + 5, kHeight / 2, 1, 1}), 0, 0).g;
  EXPECT_NEAR(hard, full, 0.01f * full) << "a single sample has a hard shadow";
}

// Half of what a floor sees beside a high wall is the wall.
TEST(Tracer, SamplesOfTheSurroundingsDarkenACorner) {
  BoxOnFloor box;
  const auto tracer = Trace(box.scene, BoxOnFloor::Mesh);
  tracer->Update(box.scene, {.everywhere = glm::vec3(1.0f)});
  const auto at = [&](double x_m) {
    box.camera.target_m = {x_m, 0.0, 0.0};
    box.camera.eye_m = {x_m, 0.0, 4.0};
    return Mean(*tracer, Eye::Of(box.camera, kWidth, kHeight), kWidth / 2, kHeight / 2, 64).g;
  };
  const float open = at(1.5);
  EXPECT_NEAR(at(0.5 * BoxOnFloor::kSide_m + 0.01), 0.5f * open, 0.1f * open);
}

TEST(Tracer, OneMirrorRayForFourPixelsShowsNearlyTheSame) {
  view::Scene scene = view::KnownScene();
  for (view::Instance& instance : scene.instances) {
    instance.material.metallic = 1.0f;
    instance.material.roughness = 0.1f;
  }
  const auto tracer = Trace(scene);
  const Eye eye = Eye::Of(view::KnownCamera(), kWidth, kHeight);
  const LitTile all = tracer->Draw(eye, kWhole), half = tracer->Draw(eye, kWhole, {tiles::Mirrors::kHalf});
  const LitTile none = tracer->Draw(eye, kWhole, {tiles::Mirrors::kNone});
  const auto difference = [&](const LitTile& other) {
    double sum = 0.0;
    for (std::size_t i = 0; i < all.light.values.size(); ++i) {
      sum += std::abs(static_cast<double>(all.light.values[i] - other.light.values[i]));
    }
    return sum;
  };
  EXPECT_GT(difference(half), 0.0);
  EXPECT_LT(difference(half), 0.2 * difference(none));
}

}  // namespace
}  // namespace raytrace
