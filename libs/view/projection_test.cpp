#include "view/projection.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "view/free_camera.hpp"
#include "view/scene.hpp"

namespace view {
namespace {

scene::Camera Front() {
  scene::Camera camera;
  camera.eye_m = {0.0, -2.0, 0.0};
  camera.target_m = {0.0, 0.0, 0.0};
  camera.vertical_fov_rad = 2.0 * std::atan(0.5);  // half height 1 m at 2 m
  return camera;
}

TEST(Projection, PinholeAgreesWithHandComputedPixels) {
  // Looking along +y with z up, x is to the right. At depth 2 m, 1 m is half the height: 100 px.
  const glm::dvec3 centre = ProjectToPixel(Front(), 400, 200, {0, 0, 0});
  EXPECT_NEAR(centre.x, 200.0, 1e-9);
  EXPECT_NEAR(centre.y, 100.0, 1e-9);
  EXPECT_NEAR(centre.z, 2.0, 1e-12);
  const glm::dvec3 off = ProjectToPixel(Front(), 400, 200, {0.5, 0, 1.0});
  EXPECT_NEAR(off.x, 250.0, 1e-9);
  EXPECT_NEAR(off.y, 0.0, 1e-9);
}

TEST(Projection, MatricesAgreeWithThePinhole) {
  const glm::dvec3 p_W(0.3, 0.4, -0.2);
  const glm::dvec4 clip =
      ProjectionMatrix(Front().vertical_fov_rad, 2.0, 0.01, 10.0) * ViewMatrix(Front()) * glm::dvec4(p_W, 1.0);
  const glm::dvec3 pixel = ProjectToPixel(Front(), 400, 200, p_W);
  EXPECT_NEAR(200.0 * (1.0 + clip.x / clip.w), pixel.x, 1e-9);
  EXPECT_NEAR(100.0 * (1.0 - clip.y / clip.w), pixel.y, 1e-9);
}

TEST(Projection, SunMatrixContainsTheSphere) {
  const glm::dvec3 centre(1.0, 2.0, 3.0);
  const glm::dmat4 clip_W = SunMatrix({0.3, 0.4, 0.85}, centre, 0.5);
  for (const glm::dvec3& d : {glm::dvec3(0.5, 0, 0), glm::dvec3(0, -0.5, 0), glm::dvec3(0, 0, 0.5)}) {
    const glm::dvec4 clip = clip_W * glm::dvec4(centre + d, 1.0);
    for (int k = 0; k < 3; ++k) EXPECT_LE(std::abs(clip[k]), 1.0);
  }
  // A point nearer to the sun has the smaller depth.
  const glm::dvec4 near = clip_W * glm::dvec4(centre + 0.1 * glm::normalize(glm::dvec3(0.3, 0.4, 0.85)), 1.0);
  EXPECT_LT(near.z, (clip_W * glm::dvec4(centre, 1.0)).z);
}

TEST(FreeCamera, OrbitKeepsTheDistanceAndTheTarget) {
  FreeCamera camera(Front());
  camera.Orbit(1.1, 0.4);
  EXPECT_NEAR(glm::length(camera.camera().eye_m - camera.camera().target_m), 2.0, 1e-12);
  camera.Orbit(0.0, 10.0);  // stops short of the pole
  EXPECT_LT(camera.camera().eye_m.z, 2.0);
  camera.Zoom(0.5);
  EXPECT_NEAR(glm::length(camera.camera().eye_m), 1.0, 1e-12);
}

TEST(FreeCamera, FlyMovesAlongTheAxesOfTheView) {
  FreeCamera camera(Front());
  camera.Fly(0.1, 0.2, 0.3);
  EXPECT_NEAR(glm::length(camera.camera().eye_m - glm::dvec3(0.1, -1.7, 0.2)), 0.0, 1e-12);
  EXPECT_NEAR(glm::length(camera.camera().target_m - glm::dvec3(0.1, 0.3, 0.2)), 0.0, 1e-12);
}

Scene SceneWithAPart(const core::Pose& X_WO) {
  Scene scene;
  scene.instances.resize(1);
  scene.instances[0].X_WM = X_WO;
  return scene;
}

TEST(PlaceCamera, AMountedCameraTurnsWithItsObject) {
  scene::Camera camera;
  camera.object = 0;
  camera.is_mounted = true;
  camera.eye_m = {0.1, 0.0, 0.0};
  camera.target_m = {1.0, 0.0, 0.0};
  // A quarter turn about x: the object's z, upwards in its picture, is W's -y.
  const core::Pose X_WO{glm::angleAxis(std::acos(-1.0) / 2.0, glm::dvec3(1, 0, 0)), {5.0, 6.0, 7.0}};
  const scene::Camera placed = PlaceCamera(camera, SceneWithAPart(X_WO));
  EXPECT_LT(glm::distance(placed.eye_m, glm::dvec3(5.1, 6.0, 7.0)), 1e-12);
  EXPECT_LT(glm::distance(placed.up, glm::dvec3(0.0, -1.0, 0.0)), 1e-12);
  EXPECT_EQ(placed.object, -1);
  const glm::dvec3 above = ProjectToPixel(placed, 100, 100, {5.6, 5.9, 7.0});
  EXPECT_LT(above.y, 50.0) << "upwards in the picture is the object's z";
}

TEST(PlaceCamera, AFollowingCameraKeepsItsDirection) {
  scene::Camera camera;
  camera.eye_m = {0.0, -1.0, 0.0};
  const core::Pose X_WO{glm::angleAxis(1.0, glm::dvec3(0, 0, 1)), {0.0, 0.0, 0.5}};
  Scene scene = SceneWithAPart(X_WO);
  const scene::Camera following = Follow(camera, 0, scene);
  EXPECT_LT(glm::distance(PlaceCamera(following, scene).eye_m, camera.eye_m), 1e-12) << "the same view at first";
  scene.instances[0].X_WM.translation.x = 2.0;
  const scene::Camera placed = PlaceCamera(following, scene);
  EXPECT_LT(glm::distance(placed.eye_m, glm::dvec3(2.0, -1.0, 0.0)), 1e-12);
  EXPECT_LT(glm::distance(placed.target_m, glm::dvec3(2.0, 0.0, 0.0)), 1e-12);
}

TEST(PlaceCamera, AViewIsALineOfAScenario) {
  Assets assets;
  assets.instance_names = {"palm"};
  scene::Camera camera;
  camera.name = "view_1";
  camera.eye_m = {0.5, -0.8, 0.25};
  camera.vertical_fov_rad = glm::radians(45.0);
  camera.object = 0;
  EXPECT_EQ(CameraXml(camera, assets),
            "<camera name=\"view_1\" eye_m=\"0.5000 -0.8000 0.2500\" target_m=\"0.0000 0.0000 0.0000\" "
            "vertical_fov_deg=\"45\" follows=\"palm\"/>");
}

}  // namespace
}  // namespace view
