#include "view/scene_mirror.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/hand_limits.hpp"

namespace view {
namespace {

// Objects: 0 plate (fixed), 1 block (physics), 2 palm, 3 left jaw, 4 right jaw, 5 lamp. Pair 0: block/plate.
scene::Scenario SmallScenario() {
  scene::Scenario scenario;
  scenario.name = "small";
  scenario.title = "A small scene";
  const auto add = [&](const char* name, scene::Owner owner, scene::HandPart part = scene::HandPart::kNone) {
    scene::Object object;
    object.name = name;
    object.owner = owner;
    object.part = part;
    object.role = part == scene::HandPart::kNone ? -1 : 0;
    object.visual_mesh = std::string("/") + name + ".obj";
    scenario.objects.push_back(object);
  };
  add("plate", scene::Owner::kFixed);
  add("block", scene::Owner::kPhysics);
  add("palm", scene::Owner::kHand, scene::HandPart::kPalm);
  add("jaw_left", scene::Owner::kHand, scene::HandPart::kJawLeft);
  add("jaw_right", scene::Owner::kHand, scene::HandPart::kJawRight);
  add("lamp", scene::Owner::kFixed);
  scenario.objects[5].is_lamp = true;
  scenario.objects[5].lamp_color = {0.0f, 1.0f, 0.0f};
  scenario.objects[4].visual_mesh = scenario.objects[3].visual_mesh;
  scene::Pair pair;
  pair.sampled = 1;
  pair.field = 0;
  scenario.pairs.push_back(pair);
  scene::Device device;
  device.role = "right";
  device.palm = 2;
  device.jaw_left = 3;
  device.jaw_right = 4;
  device.X_WD_start.translation = {0.0, 0.0, 1.0};
  device.opening_start_m = 0.06;
  scenario.devices.push_back(device);
  return scenario;
}

core::ContactSet BlockOnPlate(double depth_m, bool is_in_contact = true) {
  core::ContactSet set;
  set.sampled_body = 1;
  set.field_body = 0;
  set.is_in_contact = is_in_contact;
  core::ContactPlane plane;
  plane.p_S = {0.01f, 0.0f, static_cast<float>(-depth_m)};
  plane.q_G = {0.0f, 0.0f, 0.0f};
  plane.n_G = {0.0f, 0.0f, 1.0f};
  plane.stiffness_N_per_m = 1000.0f;
  set.planes.push_back(plane);
  return set;
}

bool HasText(const Scene& scene, const std::string& part) {
  for (const TextLine& line : scene.texts) {
    if (line.text.find(part) != std::string::npos) return true;
  }
  return false;
}

TEST(SceneMirror, StartsAtThePosesOfTheScenario) {
  const SceneMirror mirror(SmallScenario());
  const Scene& scene = mirror.scene();
  ASSERT_EQ(scene.instances.size(), 6u);
  EXPECT_EQ(scene.assets->meshes.size(), 5u);  // the jaws share one mesh
  EXPECT_EQ(scene.instances[3].mesh, scene.instances[4].mesh);
  EXPECT_FALSE(scene.instances[0].is_movable);
  EXPECT_TRUE(scene.instances[1].is_movable);
  EXPECT_NEAR(scene.instances[3].X_WM.translation.x, -0.03, 1e-12);
  EXPECT_NEAR(scene.instances[4].X_WM.translation.x, 0.03, 1e-12);
  EXPECT_NEAR(scene.instances[2].X_WM.translation.z, 1.0, 1e-12);
}

TEST(SceneMirror, ThePictureIsOfTheScenariosTimeAndSaysWhich) {
  scene::Scenario scenario = SmallScenario();
  scenario.place.epoch = *space::ParseInstant("2014-03-01T12:00:00Z");
  scenario.place.orbit.altitude_m = 400e3;
  SceneMirror mirror(scenario);
  EXPECT_TRUE(HasText(mirror.scene(), "2014-03-01 12:00:00 UTC"));
  const glm::dvec3 sun_W = glm::normalize(scenario.place.sun_W);
  EXPECT_LT(glm::distance(mirror.scene().space.sun_direction_W, sun_W), 1e-9);
  const core::Pose X_WE = mirror.scene().space.X_WE;

  core::PhysicsState state;
  state.time_ns = 90'000'000'000;
  mirror.Apply(state);
  mirror.Refresh(0);
  EXPECT_TRUE(HasText(mirror.scene(), "2014-03-01 12:01:30 UTC"));
  const glm::dquat turned = mirror.scene().space.X_WE.rotation * glm::conjugate(X_WE.rotation);
  EXPECT_NEAR(glm::angle(turned), 2.0 * std::acos(-1.0) * 90.0 / 86164.1, 1e-8);
  const double moved_m = glm::distance(mirror.scene().space.X_WE.translation, X_WE.translation);
  EXPECT_NEAR(moved_m, 90.0 * 7668.6, 1500.0);  // a chord
}

TEST(SceneMirror, BodiesFollowPhysics) {
  SceneMirror mirror(SmallScenario());
  core::PhysicsState state;
  state.time_ns = 1'500'000'000;
  core::BodyState body;
  body.object = 1;
  body.X_WO = {glm::angleAxis(0.3, glm::dvec3(0, 0, 1)), {0.1, 0.2, 0.3}};
  state.bodies.push_back(body);
  state.header.through_physics.id = core::MakeTraceId(0, 7);
  mirror.Apply(state);
  EXPECT_EQ(mirror.scene().instances[1].X_WM.translation, body.X_WO.translation);
  EXPECT_EQ(mirror.scene().instances[1].X_WM.rotation, body.X_WO.rotation);
  EXPECT_EQ(mirror.scene().instances[0].X_WM.translation, glm::dvec3(0.0));
  EXPECT_EQ(mirror.scene().through_physics.id, core::MakeTraceId(0, 7));
  EXPECT_EQ(mirror.scene().time_ns, 1'500'000'000);
}

TEST(SceneMirror, UnknownBodiesPairsAndRolesChangeNothing) {
  SceneMirror mirror(SmallScenario());
  core::PhysicsState state;
  core::BodyState body;
  body.object = 40;
  state.bodies.push_back(body);
  mirror.Apply(state);
  core::HapticProxy proxy;
  proxy.role_index = 3;
  mirror.Apply(proxy);
  core::ContactSet set = BlockOnPlate(0.001);
  set.pair_index = 9;
  mirror.Apply(set, 0);
  mirror.Refresh(0);
  EXPECT_TRUE(mirror.scene().arrows.empty());
  EXPECT_NEAR(mirror.scene().instances[2].X_WM.translation.z, 1.0, 1e-12);
}

TEST(SceneMirror, HandIsDrawnAtTheCouplingPoseAndJawsFollowTheOpening) {
  SceneMirror mirror(SmallScenario());
  core::HapticProxy proxy;
  proxy.X_WD.translation = {0.0, 0.0, -0.01};
  // A quarter turn about z: the palm's x axis, along which the jaws part, is world y.
  proxy.X_WC = {glm::angleAxis(std::acos(-1.0) / 2.0, glm::dvec3(0, 0, 1)), {0.5, 0.0, 0.0}};
  proxy.opening_m = 0.02;
  mirror.Apply(proxy);
  const auto& instances = mirror.scene().instances;
  EXPECT_NEAR(glm::length(instances[2].X_WM.translation - glm::dvec3(0.5, 0.0, 0.0)), 0.0, 1e-12);
  EXPECT_NEAR(glm::length(instances[3].X_WM.translation - glm::dvec3(0.5, -0.01, 0.0)), 0.0, 1e-12);
  EXPECT_NEAR(glm::length(instances[4].X_WM.translation - glm::dvec3(0.5, 0.01, 0.0)), 0.0, 1e-12);
}

core::DeviceCommand Command(double force_N, std::uint8_t role = 0) {
  core::DeviceCommand command;
  command.role_index = role;
  command.F_Do_W.force_N.z = force_N;
  return command;
}

// A hand that carries something presses on nothing else: the coupling's share is zero, the grasp's is not.
TEST(SceneMirror, TheFeltForceIsAllThatIsSentToTheDevice) {
  SceneMirror mirror(SmallScenario());
  mirror.Apply(core::HapticProxy{});
  mirror.Apply(Command(20.7), 1'000);
  mirror.Apply(Command(9.9, 3), 1'000);  // of a role that the scenario does not have
  mirror.Refresh(1'000);
  EXPECT_TRUE(HasText(mirror.scene(), "felt force 20.7 N"));
  mirror.Refresh(1'001 + SceneMirror::kContactAge_ns);
  EXPECT_TRUE(HasText(mirror.scene(), "felt force 0.0 N")) << "no command any more";
}

TEST(SceneMirror, EachHandHasItsOwnFeltForce) {
  scene::Scenario scenario = SmallScenario();
  scenario.devices.push_back(scenario.devices[0]);
  SceneMirror mirror(scenario);
  mirror.Apply(Command(3.25), 0);
  mirror.Apply(Command(0.5, 1), 0);
  mirror.Refresh(0);
  EXPECT_TRUE(HasText(mirror.scene(), "felt force 3.2 N / 0.5 N"));
}

TEST(SceneMirror, NamesTheDeepestOfThePairsThatTouch) {
  SceneMirror mirror(SmallScenario());
  core::CollisionMatrix matrix;
  matrix.num_touching = 2;
  matrix.collisions.push_back({.sampled_body = 2, .field_body = 0, .depth_m = 0.0001f, .force_N = 9.0f});
  matrix.collisions.push_back({.sampled_body = 1, .field_body = 0, .depth_m = 0.0025f, .force_N = 4.0f});
  mirror.Apply(matrix, 0, 0);
  mirror.Refresh(0);
  EXPECT_TRUE(HasText(mirror.scene(), "2 in contact, deepest block / plate 2.50 mm, 4.0 N"));
  matrix.collisions[1].force_error_N = 0.25f;
  mirror.Apply(matrix, 0, 0);
  mirror.Refresh(0);
  EXPECT_TRUE(HasText(mirror.scene(), "2 in contact, deepest block / plate 2.50 mm, 4.0 +- 0.25 N"));
  mirror.Refresh(SceneMirror::kContactAge_ns + 1);
  EXPECT_FALSE(HasText(mirror.scene(), "in contact"));
}

TEST(SceneMirror, CountsThePairsOfBothNodesThatComputeThem) {
  SceneMirror mirror(SmallScenario());
  core::CollisionMatrix of_haptic, of_physics;
  of_haptic.num_touching = of_physics.num_touching = 1;
  of_haptic.collisions.push_back({.sampled_body = 2, .field_body = 0, .depth_m = 0.0001f, .force_N = 9.0f});
  of_physics.collisions.push_back({.sampled_body = 1, .field_body = 0, .depth_m = 0.0025f, .force_N = 4.0f});
  mirror.Apply(of_haptic, 0, 0);
  mirror.Apply(of_physics, 1, 0);
  mirror.Refresh(0);
  EXPECT_TRUE(HasText(mirror.scene(), "2 in contact, deepest block / plate 2.50 mm, 4.0 N"));
}

TEST(SceneMirror, SaysHowFarAHandsCouplingIsFromItsLimitOnceThatIsMeasured) {
  scene::Scenario scenario = SmallScenario();
  SceneMirror mirror(scenario);
  mirror.Refresh(0);
  EXPECT_FALSE(HasText(mirror.scene(), "stable up to"));
  core::Figures figures;
  figures.items.push_back({core::StiffnessLimitName(scenario.devices[0].role), 3.94});
  mirror.ApplyBridge(figures);
  mirror.Refresh(0);
  EXPECT_TRUE(HasText(mirror.scene(), "stable up to 3.9 times the hand's stiffness"));
}

TEST(SceneMirror, KnowsWhereAPersonWhoSteersGoesNextAndThatNobodyIsSimulatedThen) {
  scene::Scenario scenario = SmallScenario();
  SceneMirror mirror(scenario);
  EXPECT_TRUE(HasText(mirror.scene(), "SIMULATED OPERATOR"));
  EXPECT_TRUE(mirror.scene().guides.empty());
  core::Figures figures;
  double value = 1.0;  // GuideKind::kMove, then 2 to 7
  for (const char* name : core::kGuideFigures) {
    figures.items.push_back({core::GuideName(scenario.devices[0].role, name), value++});
  }
  mirror.ApplyBridge(figures);
  mirror.Refresh(0);
  ASSERT_EQ(mirror.scene().guides.size(), scenario.devices.size());
  EXPECT_EQ(mirror.scene().guides[0].kind, core::GuideKind::kMove);
  EXPECT_EQ(mirror.scene().guides[0].way_W_m, glm::dvec3(2, 3, 4));
  EXPECT_EQ(mirror.scene().guides[0].turn_W_rad, glm::dvec3(5, 6, 7));
  EXPECT_FALSE(HasText(mirror.scene(), "SIMULATED OPERATOR"));
  EXPECT_TRUE(HasText(mirror.scene(), "SIMULATED ARM"));
}

TEST(SceneMirror, SaysWhichDeviceIsNotThereAndWhy) {
  SceneMirror mirror(SmallScenario());
  core::DeviceHealth health;
  health.name = "omega.7";
  health.status = "gone";
  health.why = "unplugged";
  mirror.Apply(health);
  mirror.Refresh(0);
  EXPECT_TRUE(HasText(mirror.scene(), "omega.7 is gone, unplugged"));
  health.status = "alive";
  mirror.Apply(health);
  mirror.Refresh(0);
  EXPECT_FALSE(HasText(mirror.scene(), "omega.7"));
}

TEST(SceneMirror, ASheetStartsFlatAndFollowsItsNodes) {
  scene::Scenario scenario = SmallScenario();
  scenario.objects[1].X_WO.translation = {0.0, 0.0, 2.0};
  scene::Sheet sheet;
  sheet.size_x_m = 0.4;
  sheet.size_y_m = 0.2;
  sheet.cells_x = 4;
  sheet.cells_y = 2;
  scenario.objects[1].sheet = sheet;
  SceneMirror mirror(scenario);
  ASSERT_EQ(mirror.scene().sheets.size(), 1u);
  const Sheet& shown = mirror.scene().sheets[0];
  ASSERT_EQ(shown.p_W.size(), 15u);
  EXPECT_EQ(shown.num_columns, 5u);
  EXPECT_LT(glm::distance(shown.p_W[0], glm::vec3(-0.2f, -0.1f, 2.0f)), 1e-6f);
  EXPECT_LT(glm::distance(shown.p_W[14], glm::vec3(0.2f, 0.1f, 2.0f)), 1e-6f);
  const std::uint64_t version = shown.version;
  core::SheetState state;
  state.object = 1;
  state.p_W.resize(14);
  mirror.Apply(state);  // of another size
  EXPECT_EQ(shown.version, version);
  state.p_W.resize(15);
  state.p_W[7] = {1.0f, 2.0f, 3.0f};
  mirror.Apply(state);
  EXPECT_NE(shown.version, version);
  EXPECT_EQ(shown.p_W[7], glm::vec3(1.0f, 2.0f, 3.0f));
}

// A skin over the block and a jaw, whose mesh frame is 0.1 m above the block's.
TEST(SceneMirror, ASkinGoesWithTheObjectsThatItsJointsName) {
  scene::Scenario scenario = SmallScenario();
  scenario.scenery.push_back({"hose", "/hose.glb", {{1, 0, 0, 0}, {0, 0, 0.1}}, {"block", "jaw_left"}, ""});
  scenario.scenery.push_back({"spare", "/hose.glb", {}, {}, ""});
  SceneMirror mirror(scenario);
  mirror.Refresh(0);
  const Instance& hose = mirror.scene().instances[6];
  EXPECT_NE(hose.mesh, mirror.scene().instances[7].mesh) << "a mesh that bends has one instance";
  EXPECT_EQ(mirror.scene().assets->meshes.at(hose.mesh), "/hose.glb");
  const core::Pose X_WB = {glm::angleAxis(0.5, glm::dvec3(1, 0, 0)), {0.2, 0.3, 0.4}};
  core::PhysicsState state;
  core::BodyState block;
  block.object = 1;
  block.X_WO = X_WB;
  state.bodies.push_back(block);
  mirror.Apply(state);
  mirror.Refresh(0);
  const core::Pose X_WM = X_WB * core::Pose{{1, 0, 0, 0}, {0, 0, 0.1}};
  EXPECT_LT(glm::distance(hose.X_WM.translation, X_WM.translation), 1e-12);
  ASSERT_EQ(hose.posture->size(), 2u);
  EXPECT_LT(glm::distance((*hose.posture)[0].translation, glm::dvec3(0, 0, -0.1)), 1e-12);
  const glm::dvec3 p_WJaw = hose.X_WM * (*hose.posture)[1].translation;
  EXPECT_LT(glm::distance(p_WJaw, mirror.scene().instances[3].X_WM.translation), 1e-12);
  const Posture before = hose.posture;
  mirror.Apply(state);
  mirror.Refresh(0);
  EXPECT_EQ(hose.posture, before) << "what has not moved is not bent anew";
  state.bodies[0].X_WO.translation.x += 0.01;
  mirror.Apply(state);
  mirror.Refresh(0);
  EXPECT_NE(hose.posture, before);
}

TEST(SceneMirror, LampsFollowLogic) {
  SceneMirror mirror(SmallScenario());
  EXPECT_EQ(mirror.scene().instances[5].material.emissive, 1.1f * glm::vec3(0, 1, 0));
  core::LogicStatus status;
  status.step = "switch_off";
  status.hint = "Turn off the switch";
  status.lamps.push_back({.object = 5, .red = 1.0f, .green = 0.0f, .blue = 0.0f});
  mirror.Apply(status);
  mirror.Refresh(0);
  EXPECT_EQ(mirror.scene().instances[5].material.emissive, 1.1f * glm::vec3(1, 0, 0));
  ASSERT_EQ(mirror.scene().lamps.size(), 1u);
  EXPECT_EQ(mirror.scene().lamps[0].color, glm::vec3(1, 0, 0));
  EXPECT_TRUE(HasText(mirror.scene(), "switch_off"));
  EXPECT_TRUE(HasText(mirror.scene(), "Turn off the switch"));
}

TEST(SceneMirror, ArrowsAppearAndDisappearWithContact) {
  SceneMirror mirror(SmallScenario());
  mirror.Apply(BlockOnPlate(0.002), 1'000);
  mirror.Refresh(1'000);
  ASSERT_EQ(mirror.scene().arrows.size(), 1u);
  const Arrow& arrow = mirror.scene().arrows[0];
  EXPECT_NEAR(glm::length(arrow.p_WTail - glm::dvec3(0.01, 0.0, -0.002)), 0.0, 1e-8);
  // 1000 N/m times 2 mm is 2 N, upwards: from G to S.
  EXPECT_NEAR(arrow.vector_W.z, kArrowBase_m + 2.0 * kArrowPerNewton_m, 1e-8);
  mirror.Apply(BlockOnPlate(0.002, false), 2'000);
  mirror.Refresh(2'000);
  EXPECT_TRUE(mirror.scene().arrows.empty());
}

TEST(SceneMirror, NeighbouringPointsWithTheSameNormalShareAnArrow) {
  SceneMirror mirror(SmallScenario());
  core::ContactSet set = BlockOnPlate(0.002);
  core::ContactPlane plane = set.planes[0];
  plane.p_S.x = -0.01f;  // 20 mm beside the first, twice as stiff
  plane.stiffness_N_per_m = 2000.0f;
  set.planes.push_back(plane);
  plane.p_S.x = 0.2f;  // far away
  set.planes.push_back(plane);
  plane.p_S = {0.01f, 0.0f, 0.0f};  // near, but pushing sideways
  plane.n_G = {1.0f, 0.0f, 0.0f};
  plane.q_G = {0.011f, 0.0f, 0.0f};
  set.planes.push_back(plane);
  mirror.Apply(set, 0);
  mirror.Refresh(0);
  ASSERT_EQ(mirror.scene().arrows.size(), 3u);
  // 2 N at x = 0.01 and 4 N at x = -0.01: the centre of pressure is at -0.01/3.
  EXPECT_NEAR(mirror.scene().arrows[0].p_WTail.x, -0.01 / 3.0, 1e-8);
  EXPECT_NEAR(mirror.scene().arrows[0].vector_W.z, kArrowBase_m + 6.0 * kArrowPerNewton_m, 1e-8);
}

TEST(SceneMirror, ArrowsVanishWhenTheBodyHasMovedAway) {
  SceneMirror mirror(SmallScenario());
  mirror.Apply(BlockOnPlate(0.002), 0);
  core::PhysicsState state;
  core::BodyState body;
  body.object = 1;
  body.X_WO.translation = {0.0, 0.0, 0.0021};
  state.bodies.push_back(body);
  mirror.Apply(state);
  mirror.Refresh(0);
  EXPECT_TRUE(mirror.scene().arrows.empty());
}

TEST(SceneMirror, ArrowsOfASilentPairAreDropped) {
  SceneMirror mirror(SmallScenario());
  mirror.Apply(BlockOnPlate(0.002), 0);
  mirror.Refresh(SceneMirror::kContactAge_ns);
  EXPECT_EQ(mirror.scene().arrows.size(), 1u);
  mirror.Refresh(SceneMirror::kContactAge_ns + 1);
  EXPECT_TRUE(mirror.scene().arrows.empty());
}

TEST(SceneMirror, ArrowOfAWrenchStartsOnItsAxis) {
  SceneMirror mirror(SmallScenario());
  core::ContactSet set = BlockOnPlate(0.0);
  set.planes.clear();
  // 5 N along z through the point (0.1, 0.2, anything): torque about So is p x f.
  set.F_So_W.force_N = {0.0, 0.0, 5.0};
  set.F_So_W.torque_Nm = glm::cross(glm::dvec3(0.1, 0.2, 0.7), set.F_So_W.force_N);
  mirror.Apply(set, 0);
  mirror.Refresh(0);
  ASSERT_EQ(mirror.scene().arrows.size(), 1u);
  EXPECT_NEAR(glm::length(mirror.scene().arrows[0].p_WTail - glm::dvec3(0.1, 0.2, 0.0)), 0.0, 1e-12);
}

TEST(SceneMirror, ShowsWhetherTheArmIsSimulatedAndTheLatency) {
  SceneMirror mirror(SmallScenario());
  EXPECT_TRUE(HasText(mirror.scene(), "SIMULATED"));
  mirror.Apply(
      LiveFigures{.frames_per_s = 20.0, .render_scale = 0.75, .t2_state_ms = 3.4, .t2_image_ms = 41.0, .dropped = 2});
  mirror.Refresh(0);
  EXPECT_TRUE(HasText(mirror.scene(), "hand to scene 3.4 ms"));
  EXPECT_TRUE(HasText(mirror.scene(), "20 fps at scale 0.75"));
  scene::Scenario real = SmallScenario();
  real.devices[0].type = "hug";
  EXPECT_FALSE(HasText(SceneMirror(real).scene(), "SIMULATED"));
}

TEST(SceneMirror, ShowsWhatMusclesTell) {
  SceneMirror mirror(SmallScenario());
  const std::string role = SmallScenario().devices[0].role;
  core::Figures figures;
  mirror.ApplyBridge(figures);
  mirror.Refresh(0);
  EXPECT_FALSE(HasText(mirror.scene(), "muscles"));
  figures.items.push_back({"hand." + role + ".muscle_share", 0.45});
  mirror.ApplyBridge(figures);
  mirror.Refresh(0);
  EXPECT_TRUE(HasText(mirror.scene(), role + ": grip by muscles (SIMULATED)  45 %"));
  figures.items[0].value = -1.0;
  mirror.ApplyBridge(figures);
  mirror.Refresh(0);
  EXPECT_TRUE(HasText(mirror.scene(), "too many faults"));
}

TEST(SceneMirror, ShowsAFailureWithItsReason) {
  SceneMirror mirror(SmallScenario());
  core::LogicStatus status;
  status.step = "insert_new";
  status.is_failed = true;
  status.why = "no progress for 20 s";
  mirror.Apply(status);
  mirror.Refresh(0);
  EXPECT_TRUE(HasText(mirror.scene(), "failed: insert_new"));
  EXPECT_TRUE(HasText(mirror.scene(), "no progress for 20 s"));
}

// Only what is chosen.
Choices Only(Overlay overlay) {
  Choices choices;
  choices.overlays.reset();
  choices.overlays[IndexOf(overlay)] = true;
  return choices;
}

TEST(SceneMirror, TheFeltForceIsAnArrowAtTheHandWithItsNumbers) {
  SceneMirror mirror(SmallScenario());
  mirror.Choose(Only(Overlay::kFeltForce));
  core::DeviceCommand command = Command(5.0);
  command.F_Do_W.torque_Nm = {0.0, 0.25, 0.0};
  mirror.Apply(command, 0);
  mirror.Refresh(0);
  ASSERT_EQ(mirror.scene().arrows.size(), 1u);
  EXPECT_EQ(mirror.scene().arrows[0].p_WTail, glm::dvec3(0.0, 0.0, 1.0));
  EXPECT_NEAR(mirror.scene().arrows[0].vector_W.z, kArrowBase_m + 5.0 * kArrowPerNewton_m, 1e-15);
  ASSERT_EQ(mirror.scene().rings.size(), 1u);
  EXPECT_EQ(mirror.scene().rings[0].axis_W, glm::dvec3(0.0, 1.0, 0.0));
  ASSERT_EQ(mirror.scene().labels.size(), 1u);
  EXPECT_EQ(mirror.scene().labels[0].text, "5.0 N  0.25 Nm");
}

TEST(SceneMirror, APhantomStandsWhereTheDeviceIsWhenTheToolIsElsewhere) {
  SceneMirror mirror(SmallScenario());
  mirror.Choose(Only(Overlay::kPhantom));
  core::HapticProxy proxy;
  proxy.opening_m = 0.04;
  mirror.Apply(proxy);
  mirror.Refresh(0);
  EXPECT_TRUE(mirror.scene().phantoms.empty()) << "the two coincide";
  proxy.X_WD.translation = {0.0, 0.0, -0.005};
  mirror.Apply(proxy);
  mirror.Refresh(0);
  ASSERT_EQ(mirror.scene().phantoms.size(), 3u);
  EXPECT_EQ(mirror.scene().phantoms[0].instance, 2u);
  EXPECT_EQ(mirror.scene().phantoms[0].X_WM.translation, proxy.X_WD.translation);
  EXPECT_NEAR(mirror.scene().phantoms[1].X_WM.translation.x, -0.02, 1e-12);
}

TEST(SceneMirror, AxesStandAtTheWorldsOriginAtTheSelectedPartAndAtTheHand) {
  SceneMirror mirror(SmallScenario());
  mirror.Refresh(0);
  EXPECT_TRUE(mirror.scene().axes.empty()) << "nobody wants them";
  Choices choices = Only(Overlay::kAxes);
  choices.selected = 1;
  mirror.Choose(choices);
  core::HapticProxy proxy;
  proxy.X_WC = {glm::angleAxis(0.5, glm::dvec3(0.0, 0.0, 1.0)), {0.1, 0.2, 0.3}};
  mirror.Apply(proxy);
  mirror.Refresh(0);
  const std::vector<Axes>& axes = mirror.scene().axes;
  ASSERT_EQ(axes.size(), 3u);
  EXPECT_EQ(axes[0].X_WA.translation, glm::dvec3(0.0));
  EXPECT_EQ(axes[1].X_WA.translation, mirror.scene().instances[1].X_WM.translation);
  EXPECT_EQ(axes[2].X_WA.translation, proxy.X_WC.translation);
  EXPECT_NEAR(glm::distance(axes[2].X_WA.rotate({1.0, 0.0, 0.0}), {std::cos(0.5), std::sin(0.5), 0.0}), 0.0, 1e-12);
  ASSERT_EQ(mirror.scene().labels.size(), 3u);
  EXPECT_EQ(mirror.scene().labels[0].text, "W");
  EXPECT_EQ(mirror.scene().labels[1].text, mirror.scene().assets->instance_names[1]);
  choices.selected = 2;  // the palm
  mirror.Choose(choices);
  mirror.Refresh(0);
  EXPECT_EQ(mirror.scene().axes.size(), 2u) << "one for each place";
}

TEST(SceneMirror, TheMatrixIsATableWithTheDeepestFirst) {
  SceneMirror mirror(SmallScenario());
  mirror.Choose(Only(Overlay::kMatrix));
  core::CollisionMatrix matrix;
  matrix.collisions.push_back({.sampled_body = 2, .field_body = 0, .depth_m = 0.0001f, .force_N = 9.0f});
  matrix.collisions.push_back({.sampled_body = 1, .field_body = 0, .depth_m = 0.0025f, .force_N = 4.0f});
  mirror.Apply(matrix, 0, 0);
  mirror.Refresh(0);
  std::vector<std::string> table;
  for (const TextLine& line : mirror.scene().texts) {
    if (line.anchor == Anchor::kTopRight && line.style == TextStyle::kSmall) table.push_back(line.text);
  }
  EXPECT_EQ(table, (std::vector<std::string>{"2 pairs in contact", "block / plate 2.50 mm, 4.0 N",
                                             "palm / plate 0.10 mm, 9.0 N"}));
}

TEST(SceneMirror, AnObjectIsHiddenTransparentOrHighlightedByChoice) {
  SceneMirror mirror(SmallScenario());
  Choices choices;
  choices.objects.resize(2);
  choices.objects[0].is_hidden = true;
  choices.objects[1] = {.is_transparent = true, .is_highlighted = true};
  mirror.Choose(choices);
  mirror.Refresh(0);
  const auto& instances = mirror.scene().instances;
  EXPECT_FALSE(instances[0].is_visible);
  EXPECT_EQ(instances[1].opacity, SceneMirror::kSeeThrough);
  EXPECT_GT(instances[1].highlight, 0.0f);
  mirror.Choose({});
  mirror.Refresh(0);
  EXPECT_TRUE(instances[0].is_visible);
  EXPECT_EQ(instances[1].opacity, 1.0f);
  EXPECT_EQ(instances[1].highlight, 0.0f);
}

TEST(SceneMirror, ASelectedObjectIsDescribed) {
  scene::Scenario scenario = SmallScenario();
  scenario.objects[1].mass_kg = 0.5;
  scenario.objects[1].group = "loose";
  SceneMirror mirror(scenario);
  Choices choices;
  choices.selected = 1;
  mirror.Choose(choices);
  core::PhysicsState state;
  state.bodies.push_back({.object = 1, .X_WO = {glm::dquat(1, 0, 0, 0), {0.1, 0.2, 0.3}}, .V_WO = {}});
  mirror.Apply(state);
  core::CollisionMatrix matrix;
  matrix.collisions.push_back({.sampled_body = 1, .field_body = 0, .depth_m = 0.001f, .force_N = 4.0f});
  mirror.Apply(matrix, 0, 0);
  mirror.Refresh(0);
  for (const char* part : {"block, group loose, moved by physics", "0.5 kg", "at 0.1000 0.2000 0.3000 m",
                           "rpy 0.0 0.0 0.0 deg", "block / plate 1.00 mm, 4.0 N"}) {
    EXPECT_TRUE(HasText(mirror.scene(), part)) << part;
  }
}

TEST(SceneMirror, AHintStandsAtThePartThatItNames) {
  SceneMirror mirror(SmallScenario());
  mirror.Choose(Only(Overlay::kHints));
  core::LogicStatus status;
  status.hint = "Lift the block";
  mirror.Apply(status);
  core::PhysicsState state;
  state.bodies.push_back({.object = 1, .X_WO = {glm::dquat(1, 0, 0, 0), {0.1, 0.2, 0.3}}, .V_WO = {}});
  mirror.Apply(state);
  mirror.Refresh(0);
  ASSERT_EQ(mirror.scene().labels.size(), 1u);
  EXPECT_EQ(mirror.scene().labels[0].text, "Lift the block");
  EXPECT_EQ(mirror.scene().labels[0].p_W, glm::dvec3(0.1, 0.2, 0.3));
}

}  // namespace
}  // namespace view
