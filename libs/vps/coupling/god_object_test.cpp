#include "vps/coupling/god_object.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "vps/testing/pose_at.hpp"

namespace vps {
namespace {

constexpr double kRadius_m = 0.01;

core::Pose Turned(const glm::dvec3& phi, const glm::dvec3& p = glm::dvec3(0.0)) {
  return {core::QuaternionFromRotationVector(phi), p};
}

// A wall in the frame of its body. Half-space: n . p >= d. Plate: what lies between that plane and the one
// thickness_m below it, two sides and no memory of which of them the tool came from.
struct Wall {
  glm::dvec3 n_E{0, 0, 1};
  double d_m = 0.0;
  double thickness_m = 1e9;
  std::uint16_t body = 0;
  double friction = 0.0;
  bool is_there = true;
};

// Balls fixed to the tool against walls, exactly.
class Scene {
 public:
  explicit Scene(const GodObjectParameters& parameters = {}) : hand(parameters) {}

  std::vector<glm::dvec3> balls_C{glm::dvec3(0.0)};
  double radius_m = kRadius_m;
  double look_ahead_m = 0.002;
  std::vector<Wall> walls;
  std::vector<core::Pose> X_WO{core::Pose{}};
  GodObject hand;
  ToolContact contact;

  core::Wrench Step(const core::Pose& X_WD) {
    Collide();
    return hand.Step(X_WD, contact, X_WO);
  }
  core::Wrench Hold(const core::Pose& X_WD, int cycles) {
    core::Wrench F;
    for (int i = 0; i < cycles; ++i) F = Step(X_WD);
    return F;
  }
  // The deepest that any ball is in any half-space with the tool at C now.
  [[nodiscard]] double Depth_m() const {
    double deepest_m = -1e9;
    for (const Wall& wall : walls) {
      for (const glm::dvec3& ball_C : balls_C) deepest_m = std::max(deepest_m, radius_m - Height(wall, ball_C));
    }
    return deepest_m;
  }

 private:
  [[nodiscard]] double Height(const Wall& wall, const glm::dvec3& ball_C) const {
    const glm::dvec3 p_E = X_WO[wall.body].inverse() * (hand.X_WC() * ball_C);
    return glm::dot(wall.n_E, p_E) - wall.d_m;
  }
  void Collide() {
    contact = {};
    for (std::size_t w = 0; w < walls.size(); ++w) {
      const Wall& wall = walls[w];
      if (!wall.is_there) continue;
      for (std::size_t b = 0; b < balls_C.size(); ++b) {
        const double height_m = Height(wall, balls_C[b]);
        const bool is_below = height_m < -0.5 * wall.thickness_m;
        const double gap_m = (is_below ? -height_m - wall.thickness_m : height_m) - radius_m;
        if (gap_m > look_ahead_m) {
          contact.free_distance_m = std::min(contact.free_distance_m, gap_m);
          continue;
        }
        contact.free_distance_m = std::min(contact.free_distance_m, look_ahead_m);
        const glm::dvec3 n_W = X_WO[wall.body].rotate(is_below ? -wall.n_E : wall.n_E);
        ToolPlane plane;
        plane.id = static_cast<std::uint32_t>(4 * (100 * w + b) + (is_below ? 1 : 0));
        plane.body = wall.body;
        plane.p_W = hand.X_WC() * balls_C[b] - radius_m * n_W;
        plane.n_W = n_W;
        plane.gap_m = gap_m;
        plane.friction = wall.friction;
        contact.planes.push_back(plane);
      }
    }
  }
};

// Goes there in steps of a cycle at a speed, and returns the last force.
core::Wrench Move(Scene& scene, core::Pose* X_WD, const glm::dvec3& to, double speed_m_per_s,
                  const std::function<void(const core::Wrench&)>& at_each = {}) {
  core::Wrench F;
  const glm::dvec3 from = X_WD->translation;
  const int cycles = std::max(1, static_cast<int>(std::ceil(glm::length(to - from) / (speed_m_per_s * 1e-3))));
  for (int i = 1; i <= cycles; ++i) {
    X_WD->translation = from + (static_cast<double>(i) / cycles) * (to - from);
    F = scene.Step(*X_WD);
    if (at_each) at_each(F);
  }
  return F;
}

TEST(GodObject, RestsOnAPlaneAtForceOverStiffnessWithinAMicrometre) {
  Scene scene;
  scene.walls = {{}};
  core::Pose X_WD = At(0, 0, 0.03);
  scene.hand.Reset(X_WD);
  const double depth_m = 20.0 / 2500.0;
  Move(scene, &X_WD, {0, 0, kRadius_m - depth_m}, 0.1);
  const core::Wrench F = scene.Hold(X_WD, 100);
  EXPECT_NEAR(F.force_N.z, 20.0, 1e-3);
  EXPECT_NEAR(scene.hand.X_WC().translation.z, kRadius_m, 1e-7);
  EXPECT_NEAR(kRadius_m - X_WD.translation.z, F.force_N.z / 2500.0, 1e-7);
}

TEST(GodObject, IsExactlyOnTheDeviceInTheOpenAndAfterLettingGo) {
  Scene scene;
  scene.walls = {{}};
  core::Pose X_WD = At(0, 0, 0.03);
  scene.hand.Reset(X_WD);
  Move(scene, &X_WD, {0.01, 0, 0.004}, 0.2);
  X_WD.rotation = core::QuaternionFromRotationVector({0.1, 0.2, -0.3});
  Move(scene, &X_WD, {0.0, 0.01 / 3, 0.05}, 0.2);
  const core::Wrench F = scene.Step(X_WD);
  EXPECT_EQ(scene.hand.X_WC().rotation, X_WD.rotation);
  EXPECT_EQ(glm::length(F.force_N) + glm::length(F.torque_Nm), 0.0);
  EXPECT_EQ(scene.hand.X_WC().translation, X_WD.translation);
}

TEST(GodObject, SlidesWithoutForceWhereThereIsNoFriction) {
  Scene scene;
  scene.walls = {{}};
  core::Pose X_WD = At(0, 0, 0.03);
  scene.hand.Reset(X_WD);
  Move(scene, &X_WD, {0, 0, 0.005}, 0.1);
  Move(scene, &X_WD, {0.05, 0.02, 0.005}, 0.2,
       [](const core::Wrench& F) { EXPECT_NEAR(std::hypot(F.force_N.x, F.force_N.y), 0.0, 1e-9); });
}

struct Friction : testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Coefficients, Friction, testing::Values(0.1, 0.2, 0.3, 0.4, 0.5));

TEST_P(Friction, OnAPlaneSticksUpToTheConeAndSlidesOnIt) {
  Scene scene;
  scene.walls = {{{0, 0, 1}, 0.0, 1e9, 0, GetParam()}};
  core::Pose X_WD = At(0, 0, 0.03);
  scene.hand.Reset(X_WD);
  Move(scene, &X_WD, {0, 0, 0.004}, 0.1);
  const double before_m = scene.hand.X_WC().translation.x;
  // A rolling ball would give way by turning: with this stiffness it turns by 1/100 of what it would have to.
  double breakaway_N = 0.0;
  double previous_m = before_m;
  Move(scene, &X_WD, {0.02, 0, 0.004}, 0.005, [&](const core::Wrench& F) {
    const core::Pose& X_WC = scene.hand.X_WC();
    const double bottom_m = (X_WC * glm::dvec3(0, 0, -kRadius_m)).x;
    const double ratio = -F.force_N.x / F.force_N.z;
    EXPECT_LT(ratio, 1.0001 * GetParam());
    if (breakaway_N == 0.0 && bottom_m - previous_m > 2e-6) breakaway_N = ratio * F.force_N.z;
    previous_m = bottom_m;
  });
  const core::Wrench F = scene.Step(X_WD);
  EXPECT_NEAR(-F.force_N.x / F.force_N.z, GetParam(), 0.005 * GetParam());
  EXPECT_NEAR(breakaway_N / F.force_N.z, GetParam(), 0.02 * GetParam());
}

// Three feet far from the centre of mass, dragged sideways: the device's force is the cone's.
TEST_P(Friction, OfSeveralFeetIsThatOfTheirSum) {
  Scene scene;
  scene.radius_m = 0.0;
  scene.balls_C = {{0.03, 0, -0.02}, {-0.02, 0.025, -0.02}, {-0.02, -0.03, -0.02}};
  scene.walls = {{{0, 0, 1}, 0.0, 1e9, 0, GetParam()}};
  core::Pose X_WD = At(0, 0, 0.03);
  scene.hand.Reset(X_WD);
  Move(scene, &X_WD, {0, 0, 0.012}, 0.1);
  Move(scene, &X_WD, {0.01, 0.005, 0.012}, 0.01);
  Move(scene, &X_WD, {0.05, 0.02, 0.012}, 0.1, [&](const core::Wrench& F) {
    EXPECT_NEAR(std::hypot(F.force_N.x, F.force_N.y), GetParam() * F.force_N.z, 0.01 * GetParam() * F.force_N.z);
  });
}

// Dithered for ten seconds with up to eight tenths of what it takes to slide, it is where it was.
TEST_P(Friction, ATremblingHandDoesNotWalk) {
  Scene scene;
  scene.radius_m = 0.0;
  scene.balls_C = {{0.03, 0, -0.02}, {-0.02, 0.025, -0.02}, {-0.02, -0.03, -0.02}};
  scene.walls = {{{0, 0, 1}, 0.0, 1e9, 0, GetParam()}};
  core::Pose X_WD = At(0, 0, 0.03);
  scene.hand.Reset(X_WD);
  Move(scene, &X_WD, {0, 0, 0.012}, 0.1);
  X_WD.translation.x = 0.3 * GetParam() * 0.008;
  scene.Hold(X_WD, 100);
  const glm::dvec3 start = scene.hand.X_WC().translation;
  for (int i = 0; i < 10000; ++i) {
    const double t = 1e-3 * i;
    core::Pose X_WD_now = X_WD;
    X_WD_now.translation += GetParam() * 0.008 * 0.3 * glm::dvec3(std::sin(60 * t), std::cos(47 * t), 0.0);
    X_WD_now.rotation = core::QuaternionFromRotationVector({0, 0, 4e-3 * GetParam() * std::sin(53 * t)});
    scene.Step(X_WD_now);
  }
  scene.Hold(X_WD, 10);
  EXPECT_LT(glm::length(scene.hand.X_WC().translation - start), 3e-5);
}

TEST_P(Friction, HeldBelowTheConeDoesNotCreep) {
  Scene scene;
  scene.walls = {{{0, 0, 1}, 0.0, 1e9, 0, GetParam()}};
  core::Pose X_WD = At(0, 0, 0.03);
  scene.hand.Reset(X_WD);
  Move(scene, &X_WD, {0, 0, 0.004}, 0.1);
  X_WD.translation.x += 0.9 * GetParam() * 0.006;
  scene.Hold(X_WD, 1000);
  const core::Pose before = scene.hand.X_WC();
  scene.Hold(X_WD, 10000);
  EXPECT_LT(glm::length(scene.hand.X_WC().translation - before.translation), 1e-9);
  EXPECT_GT(std::abs(X_WD.translation.x - before.translation.x), 0.8 * GetParam() * 0.006);
}

// Two walls that lean against each other by half an angle a from the vertical, pressed with F: each carries
// F / (2 sin a), so along the slot it slides at mu F / sin a.
TEST_P(Friction, InASlotIsTheWedgesTimesTheCone) {
  Scene scene;
  const double a = 0.5;
  for (const double side : {-1.0, 1.0}) {
    scene.walls.push_back({{-side * std::cos(a), 0, std::sin(a)}, 0.0, 1e9, 0, GetParam()});
  }
  core::Pose X_WD = At(0, 0, 0.06);
  scene.hand.Reset(X_WD);
  const double seat_m = kRadius_m / std::sin(a);
  Move(scene, &X_WD, {0, 0, seat_m - 0.004}, 0.1);
  double breakaway_N = 0.0;
  double previous_m = 0.0;
  const core::Wrench F = Move(scene, &X_WD, {0, 0.02, seat_m - 0.004}, 0.005, [&](const core::Wrench& now) {
    const double y_m = scene.hand.X_WC().translation.y;
    if (breakaway_N == 0.0 && y_m - previous_m > 4e-6) breakaway_N = -now.force_N.y;
    previous_m = y_m;
  });
  const double along_N = GetParam() * F.force_N.z / std::sin(a);
  EXPECT_GT(F.force_N.z, 5.0);
  EXPECT_NEAR(-F.force_N.y, along_N, 0.02 * along_N);
  EXPECT_NEAR(breakaway_N, along_N, 0.03 * along_N);
}

TEST(GodObject, SticksToABodyThatMoves) {
  Scene scene;
  scene.walls = {{{0, 0, 1}, 0.0, 1e9, 1, 0.4}};
  scene.X_WO.resize(2);
  core::Pose X_WD = At(0, 0, 0.03);
  scene.hand.Reset(X_WD);
  Move(scene, &X_WD, {0, 0, 0.004}, 0.1);
  for (int i = 0; i < 200; ++i) {
    scene.X_WO[1].translation.x += 1e-5;  // 2 mm at 10 mm/s; 6 mm of pressing hold 2.4
    scene.Step(X_WD);
  }
  const glm::dvec3 bottom = scene.hand.X_WC() * glm::dvec3(0, 0, -kRadius_m);
  EXPECT_NEAR(bottom.x, 0.002, 2e-5);
}

double SpringEnergy_J(const core::Pose& X_WC, const core::Pose& X_WD) {
  const GodObjectParameters p;
  const glm::dvec3 x = X_WC.translation - X_WD.translation;
  const glm::dvec3 phi = core::RotationVector(X_WC.rotation * glm::conjugate(X_WD.rotation));
  return 0.5 * p.stiffness_N_per_m * glm::dot(x, x) + 0.5 * p.stiffness_Nm_per_rad * glm::dot(phi, phi);
}

// Walls that stand still take energy out: with the device where it is, a step never raises the spring's energy. A long
// tool between two walls and on a floor wedges itself, and its contacts squeeze it with many times the hand's force.
TEST(GodObject, FrictionOfWallsThatStandStillGivesNoEnergy) {
  double largest_rise_J = 0.0;
  double largest_N = 0.0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    Scene scene;
    scene.balls_C = {{0.0, 0.0, -0.03}, {0.0, 0.0, 0.03}, {0.02, 0.0, -0.03}, {0.02, 0.0, 0.03}};
    scene.walls = {{{1, 0, 0}, -0.0105}, {{-1, 0, 0}, -0.0305}, {{0, 0, 1}, -0.042}, {{-0.8, 0, 0.6}, -0.046}};
    for (Wall& wall : scene.walls) wall.friction = 0.2 + 0.05 * seed;
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    core::Pose X_WD;
    scene.hand.Reset(X_WD);
    for (int push = 0; push < 40; ++push) {
      const glm::dvec3 to(0.01 * uniform(engine), 0.01 * uniform(engine), 0.03 * uniform(engine));
      const glm::dvec3 turn(0.2 * uniform(engine), 0.5 * uniform(engine), 0.2 * uniform(engine));
      for (int i = 0; i < 200; ++i) {
        X_WD.translation += 0.005 * (to - X_WD.translation);
        X_WD.rotation = glm::normalize(glm::slerp(X_WD.rotation, core::QuaternionFromRotationVector(turn), 0.005));
        const double before_J = SpringEnergy_J(scene.hand.X_WC(), X_WD);
        scene.Step(X_WD);
        largest_rise_J = std::max(largest_rise_J, SpringEnergy_J(scene.hand.X_WC(), X_WD) - before_J);
        for (const HeldContact& contact : scene.hand.contacts()) largest_N = std::max(largest_N, contact.normal_N);
      }
    }
  }
  EXPECT_LT(largest_rise_J, 1e-6 * largest_N);  // what a linearisation is off, and has gained before
}

TEST(GodObject, StaysInACornerOfThreeWalls) {
  Scene scene;
  scene.walls = {{{0, 0, 1}}, {glm::normalize(glm::dvec3(1, 0, 0.2))}, {{0, 1, 0}}};
  core::Pose X_WD = At(0.04, 0.03, 0.03);
  scene.hand.Reset(X_WD);
  Move(scene, &X_WD, {-0.02, -0.01, -0.005}, 0.2);
  const core::Wrench F = scene.Hold(X_WD, 50);
  for (const Wall& wall : scene.walls) {
    EXPECT_NEAR(glm::dot(wall.n_E, scene.hand.X_WC().translation), kRadius_m, 1e-8);
  }
  EXPECT_LT(glm::length(scene.Step(X_WD).force_N - F.force_N), 1e-9);
}

TEST(GodObject, AFaceOnAPlaneTurnsOnlyByWhatItIsTurnedFor) {
  Scene scene;
  scene.balls_C.clear();
  for (int i = 0; i < 40; ++i) {
    scene.balls_C.emplace_back(0.02 * std::cos(0.3 * i), 0.02 * std::sin(0.3 * i), -0.01);
  }
  scene.walls = {{}, {}};  // twice, as two objects that touch would
  core::Pose X_WD = At(0, 0, 0.04);
  scene.hand.Reset(X_WD);
  Move(scene, &X_WD, {0, 0, 0.016}, 0.1);
  X_WD.rotation = core::QuaternionFromRotationVector({0.002, 0, 0});
  core::Wrench F = scene.Hold(X_WD, 20);
  EXPECT_NEAR(F.force_N.z, 2500.0 * 0.004, 1e-6);
  EXPECT_NEAR(F.torque_Nm.x, -30.0 * 0.002, 1e-6);  // 60 mNm; 10 N at 20 mm carry 200
  EXPECT_LT(std::abs(core::RotationVector(scene.hand.X_WC().rotation).x), 1e-7);
  EXPECT_LT(scene.Depth_m(), 1e-8);
}

// The same scene, seen from another frame.
TEST(GodObject, FrameInvariant) {
  std::vector<std::vector<core::Wrench>> forces(2);
  const core::Pose X_UW = Turned({-0.5, 0.2, 1.0}, {3, -1, 2});
  for (int frame = 0; frame < 2; ++frame) {
    const core::Pose X = frame == 0 ? core::Pose{} : X_UW;
    Scene scene;
    scene.balls_C = {{0.02, 0, 0}, {-0.02, 0.01, 0}, {0, -0.02, 0.01}};
    scene.walls = {{{0, 0, 1}, 0, 1e9, 0, 0.3}, {glm::normalize(glm::dvec3(1, 0.2, 0.1)), -0.05, 1e9, 0, 0.2}};
    scene.X_WO = {X};
    scene.hand.Reset(X * At(0, 0, 0.03));
    for (int i = 0; i < 1500; ++i) {
      const double t = 1e-3 * i;
      const core::Pose X_WD = Turned({0.3 * std::sin(3 * t), 0.2 * t, 0.1},
                                     {-0.04 * std::sin(2 * t), 0.02 * std::cos(5 * t), 0.03 - 0.03 * std::sin(4 * t)});
      const core::Wrench F = scene.Step(X * X_WD);
      forces[static_cast<std::size_t>(frame)].push_back(
          {glm::conjugate(X.rotation) * F.force_N, glm::conjugate(X.rotation) * F.torque_Nm});
    }
  }
  double largest_N = 0.0;
  for (std::size_t i = 0; i < forces[0].size(); ++i) {
    largest_N = std::max(largest_N, glm::length(forces[0][i].force_N));
    EXPECT_LT(glm::length(forces[0][i].force_N - forces[1][i].force_N), 2e-3) << i;
    EXPECT_LT(glm::length(forces[0][i].torque_Nm - forces[1][i].torque_Nm), 1e-4) << i;
  }
  EXPECT_GT(largest_N, 20.0);
}

// A push through the centre of mass does not turn the tool, wherever the hand holds it.
TEST(GodObject, TurnsAboutItsCentreOfMass) {
  GodObjectParameters parameters;
  parameters.p_CoCm_C = {0.1, 0, 0};
  parameters.bounding_radius_m = 0.05;
  Scene scene(parameters);
  scene.balls_C = {{0.1, 0, 0}};
  scene.walls = {{}};
  core::Pose X_WD = At(0, 0, 0.03);
  scene.hand.Reset(X_WD);
  Move(scene, &X_WD, {0, 0, 0.005}, 0.1);
  const core::Wrench F = scene.Hold(X_WD, 10);
  EXPECT_NEAR(core::RotationVector(scene.hand.X_WC().rotation).y, 0.0, 1e-9);
  EXPECT_NEAR(F.force_N.z, 12.5, 1e-6);
  EXPECT_NEAR(F.torque_Nm.y, -0.1 * 12.5, 1e-6);  // about the hand's origin: p x F
}

// Without mass the spring's wrench is what the contacts make; with mass, as soon as it rests.
TEST(GodObject, FeelsTheSumOfItsContacts) {
  for (const double mass_kg : {0.0, 0.4}) {
    GodObjectParameters parameters;
    parameters.p_CoCm_C = {0.01, 0.005, -0.01};
    parameters.mass_kg = mass_kg;
    parameters.I_Cm_C_kg_m2 = mass_kg * glm::dmat3(2e-4, 3e-5, 0, 3e-5, 4e-4, 0, 0, 0, 3e-4);
    Scene scene(parameters);
    scene.balls_C = {{0.02, 0, 0}, {-0.02, 0.01, 0}, {0, -0.02, 0.01}};
    scene.walls = {{{0, 0, 1}, 0, 1e9, 0, 0.3}, {glm::normalize(glm::dvec3(1, 0.2, 0.1)), -0.05, 1e9, 0, 0.2}};
    core::Pose X_WD = Turned({0.1, 0.05, 0.2}, {0, 0, 0.05});
    scene.hand.Reset(X_WD);
    Move(scene, &X_WD, {-0.04, 0.01, 0.004}, 0.1);
    const core::Wrench F = scene.Hold(X_WD, 1500);
    core::Wrench sum;
    for (const HeldContact& contact : scene.hand.contacts()) {
      const glm::dvec3 force_N = contact.normal_N * contact.n_W + contact.tangent_W_N;
      sum += {force_N, glm::cross(contact.p_W - X_WD.translation, force_N)};
    }
    EXPECT_GT(glm::length(F.force_N), 5.0);
    EXPECT_LT(glm::length(F.force_N - sum.force_N), 1e-3) << mass_kg;
    EXPECT_LT(glm::length(F.torque_Nm - sum.torque_Nm), 1e-4 + 0.02 * glm::length(F.torque_Nm)) << mass_kg;
    EXPECT_LT(scene.Depth_m(), 1e-6);  // the contacts give way
  }
}

TEST(GodObject, AToolWithMassComesToTheDeviceWithoutSwinging) {
  GodObjectParameters parameters;
  parameters.mass_kg = 0.5;
  parameters.I_Cm_C_kg_m2 = glm::dmat3(2e-4);
  Scene scene(parameters);
  scene.hand.Reset(At(0, 0, 0));
  bool has_been_past = false;
  double before_m = 0.0;
  double before_m_per_s = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const core::Wrench F = scene.Step(At(0.01, 0, 0));
    const double speed_m_per_s = (scene.hand.X_WC().translation.x - before_m) / 1e-3;
    EXPECT_NEAR(-F.force_N.x, 0.5 * (speed_m_per_s - before_m_per_s) / 1e-3, 1e-6);  // Newton's law
    before_m = scene.hand.X_WC().translation.x;
    before_m_per_s = speed_m_per_s;
    const double past_m = scene.hand.X_WC().translation.x - 0.01;
    EXPECT_LT(past_m, 0.0015);  // a damper between the two carries it e^-2 of the step beyond
    has_been_past = has_been_past || past_m > 1e-5;
    if (has_been_past) {
      EXPECT_GT(past_m, -1e-6);
    }
  }
  EXPECT_NEAR(scene.hand.X_WC().translation.x, 0.01, 1e-6);
}

TEST(GodObject, NoForceStepWhenPlanesComeAndGo) {
  Scene scene;
  scene.walls = {{{0, 0, 1}, 0, 1e9, 0, 0.3}, {{0, 0, 1}, -1e-3, 1e9, 0, 0.3}};
  core::Pose X_WD = At(0, 0, 0.03);
  scene.hand.Reset(X_WD);
  glm::dvec3 last_N(0.0);
  double largest_step_N = 0.0;
  const auto note = [&](const core::Wrench& F) {
    largest_step_N = std::max(largest_step_N, glm::length(F.force_N - last_N));
    last_N = F.force_N;
  };
  Move(scene, &X_WD, {0, 0, 0.006}, 0.1, note);
  largest_step_N = 0.0;
  for (int i = 0; i < 3000; ++i) {
    if (i % 100 == 0) scene.walls[0].is_there = !scene.walls[0].is_there;  // 1 mm above the other: 2.5 N
    note(scene.Step(X_WD));
  }
  EXPECT_LE(largest_step_N, 0.21 * 10.0);
  for (Wall& wall : scene.walls) wall.is_there = false;
  largest_step_N = 0.0;
  const double all_N = glm::length(last_N);
  for (int i = 0; i < 10; ++i) note(scene.Step(X_WD));
  EXPECT_LE(largest_step_N, 0.21 * all_N + 1e-9);
  EXPECT_EQ(last_N.z, 0.0);
  // Comes up 4 mm inside what holds now: led out at 0.1 m/s.
  scene.walls[0].is_there = true;
  largest_step_N = 0.0;
  for (int i = 0; i < 100; ++i) note(scene.Step(X_WD));
  EXPECT_LE(largest_step_N, 2500 * 1e-4 * 1.01);
  EXPECT_NEAR(last_N.z, 2500 * 0.004, 1e-3);  // the contact gives way by 0.1 um
}

TEST(GodObject, NoForceStepWhenAPlaneJumpsByItself) {
  Scene scene;
  scene.walls = {{}};
  core::Pose X_WD = At(0, 0, 0.03);
  scene.hand.Reset(X_WD);
  Move(scene, &X_WD, {0, 0, 0.006}, 0.1);
  for (int i = 0; i < 1000; ++i) {
    if (i % 50 == 0) scene.walls[0].d_m = scene.walls[0].d_m == 0.0 ? 2e-4 : 0.0;  // 0.5 N
    const core::Wrench before = scene.Step(X_WD);
    EXPECT_LE(std::abs(scene.Step(X_WD).force_N.z - before.force_N.z), 0.11);
    if (i % 50 == 49) {
      EXPECT_NEAR(scene.hand.X_WC().translation.z, kRadius_m + scene.walls[0].d_m, 1e-7);
    }
  }
}

// A hook behind a wall, 100 mm from the hand, turned at 20 rad/s: a linear step carries it 20 um into the wall.
TEST(GodObject, ATwistDoesNotCarryItIntoAWall) {
  Scene scene;
  scene.radius_m = 0.0;
  scene.balls_C = {{0.1, 0, 0}};
  scene.walls = {{{1, 0, 0}, 0.0999}};
  scene.hand.Reset(At(0, 0, 0));
  for (int i = 0; i < 30; ++i) {
    const core::Wrench F = scene.Step(Turned({0, 0, 0.02 * std::min(i, 15)}));
    EXPECT_LT(scene.Depth_m(), 1e-6) << i;
    if (i > 15) {
      EXPECT_GT(F.force_N.x, 5.0);
    }
  }
}

TEST(GodObject, APegInATightHoleStaysInItsMiddleWithoutFriction) {
  for (const double clearance_m : {1e-4, 0.0, -1e-4}) {
    Scene scene;
    scene.balls_C = {{0, 0, 0.02}, {0, 0, -0.02}};
    for (int i = 0; i < 16; ++i) {
      const double angle = 2 * M_PI * i / 16;
      scene.walls.push_back({{std::cos(angle), std::sin(angle), 0}, -kRadius_m - 0.5 * clearance_m, 1e9, 0, 0.3});
    }
    core::Pose X_WD = At(0, 0, 0);
    scene.hand.Reset(X_WD);
    X_WD.translation.x = 1e-3;  // pressed sideways
    core::Wrench F = scene.Hold(X_WD, 200);
    EXPECT_LT(scene.Depth_m(), std::max(0.0, -0.5 * clearance_m) + 2e-6) << clearance_m;
    EXPECT_NEAR(F.force_N.x, -2500 * (1e-3 - std::max(0.5 * clearance_m, 0.0)), 0.02) << clearance_m;
    const core::Pose before = scene.hand.X_WC();
    F = scene.Hold(X_WD, 200);
    EXPECT_LT(glm::length(scene.hand.X_WC().translation - before.translation), 1e-6);
    // Planes that contradict each other make no force, so the peg is not jammed by them.
    X_WD.translation = {0, 0, 0.003};
    F = scene.Hold(X_WD, 300);
    EXPECT_LT(std::abs(F.force_N.z), 0.05) << clearance_m;
  }
}

// Two jaws close on a round bar: there is a long way out to the side.
TEST(GodObject, JawsThatCloseOnABarStayOnIt) {
  Scene scene;
  scene.balls_C = {{0, 0, 0}};
  const double tilt = 0.05;
  for (const double side : {-1.0, 1.0}) {
    scene.walls.push_back({{side * std::cos(tilt), std::sin(tilt), 0}, -kRadius_m - 1e-3, 1e9, 0, 0.3});
  }
  const core::Pose X_WD = At(0, 0, 0);
  scene.hand.Reset(X_WD);
  for (int i = 0; i < 200; ++i) {
    for (Wall& wall : scene.walls) wall.d_m += 1e-5;
    const core::Wrench F = scene.Step(X_WD);
    EXPECT_LT(std::abs(scene.hand.X_WC().translation.y), 1e-3);
    EXPECT_LT(glm::length(F.force_N), 2.5);
  }
}

// The tool stands with its foot on a flank, and its head, 15 mm beside, is under another flank of the same body that
// goes on straight where the first one ends. A place of the head that comes in view there has come through nothing.
TEST(GodObject, AFlankIsNoWallForWhatIsOnTheFlankAcross) {
  for (const bool is_neighbour_known : {false, true}) {
    GodObject hand;
    hand.Reset(At(0, 0, 0));
    const std::vector<core::Pose> X_WO(1);
    const auto plane_at = [&](std::uint32_t id, double x, double n, double gap_m) {
      const glm::dvec3 p_W = hand.X_WC() * glm::dvec3(x, 0, 0);
      return ToolPlane{id, 0, p_W, {0, 0, n}, gap_m + n * p_W.z, 0.0};
    };
    const double head_gap_m = is_neighbour_known ? 5e-6 : 5e-5;
    for (int cycle = 0; cycle < 3; ++cycle) {
      ToolContact contact;
      contact.free_distance_m = 0.002;
      contact.planes.push_back(plane_at(0, -0.0075, 1.0, 0.0));
      if (is_neighbour_known) contact.planes.push_back(plane_at(1, 0.0072, -1.0, head_gap_m));
      if (cycle == 2) contact.planes.push_back(plane_at(2, 0.0075, -1.0, head_gap_m));
      hand.Step(cycle < 2 ? At(0, 0, -0.001) : Turned({0, 0.02, 0}, {0, 0, -0.001}), contact, X_WO);
    }
    EXPECT_LT((hand.X_WC() * glm::dvec3(0.0075, 0, 0)).z, -1e-4) << is_neighbour_known;
  }
}

TEST(GodObject, DoesNotPassAThinPlateOrASheetAtAMetrePerSecond) {
  std::mt19937_64 rng(5);
  std::normal_distribution<double> normal;
  for (const double thickness_m : {0.5e-3, 0.0}) {
    for (int round = 0; round < 150; ++round) {
      Scene scene;
      scene.radius_m = round % 2 == 0 ? 0.0 : 0.002;
      scene.balls_C = {{0, 0, 0}, {0.03, 0, -0.005}, {0, 0.04, 0.01}};
      scene.walls = {{glm::normalize(glm::dvec3(normal(rng), normal(rng), normal(rng))), 0.0, thickness_m}};
      scene.walls[0].friction = 0.2;
      const glm::dvec3& n = scene.walls[0].n_E;
      const double speed_m_per_s = round % 3 == 0 ? 1.0 : round % 3 == 1 ? 0.2 : 0.05;
      glm::dvec3 across(normal(rng), normal(rng), normal(rng));
      across = glm::normalize(across - glm::dot(n, across) * n);
      core::Pose X_WD{glm::dquat(1, 0, 0, 0), 0.05 * n};
      scene.hand.Reset(X_WD);
      const double grazing = 0.1 + 0.9 * (round % 7) / 6.0;
      const glm::dvec3 to = -0.04 * n + (0.02 / grazing) * across;
      double deepest_m = 0.0;
      Move(scene, &X_WD, to, speed_m_per_s, [&](const core::Wrench&) {
        for (const glm::dvec3& ball_C : scene.balls_C) {
          deepest_m = std::max(deepest_m, scene.radius_m - glm::dot(n, scene.hand.X_WC() * ball_C));
        }
      });
      EXPECT_LT(deepest_m, 1e-5) << thickness_m << " " << round;
      EXPECT_GT(glm::dot(n, scene.hand.X_WC().translation - X_WD.translation), 0.03);
    }
  }
}

TEST(GodObject, GoesAroundTheEdgeOfAPlateToItsOtherSide) {  // the side is where the tool came from, not a ban
  Scene scene;
  scene.radius_m = 0.0;
  scene.walls = {{{0, 0, 1}, 0.0, 0.5e-3}};
  core::Pose X_WD = At(0, 0, 0.02);
  scene.hand.Reset(X_WD);
  Move(scene, &X_WD, {0, 0, 1e-4}, 0.1);
  scene.walls[0].is_there = false;  // beyond the edge
  Move(scene, &X_WD, {0, 0, -0.01}, 0.1);
  scene.walls[0].is_there = true;
  const core::Wrench F = Move(scene, &X_WD, {0, 0, 0.003}, 0.1);
  EXPECT_NEAR(F.force_N.z, -2500 * 0.0035, 1e-6);
}

TEST(GodObject, AForkHoldsAPlateFromBothSides) {
  Scene scene;
  scene.radius_m = 0.0;
  scene.look_ahead_m = 0.003;
  scene.balls_C = {{0, 0, 2e-3}, {0, 0, -2.5e-3}};  // they see one side each at first, then both
  scene.walls = {{{0, 0, 1}, 0.0, 0.5e-3}};
  core::Pose X_WD = At(0, 0, -0.0015);
  scene.hand.Reset(X_WD);
  core::Wrench F = Move(scene, &X_WD, {0, 0, 0.004}, 0.2);
  EXPECT_NEAR(F.force_N.z, -2500 * 0.002, 1e-6);
  F = Move(scene, &X_WD, {0, 0, -0.004}, 0.2);
  EXPECT_NEAR(F.force_N.z, 2500 * 0.002, 1e-6);
}

TEST(GodObject, IsHeldByTheFreeDistance) {
  GodObject hand;
  hand.Reset(At(0, 0, 0));
  ToolContact contact;
  contact.free_distance_m = 0.003;
  const std::vector<core::Pose> X_WO(1);
  hand.Step(At(0.02, 0, 0), contact, X_WO);
  EXPECT_NEAR(hand.X_WC().translation.x, 0.003, 1e-12);
}

TEST(GodObject, RepeatsItselfBitForBit) {
  std::vector<double> first;
  for (int run = 0; run < 2; ++run) {
    Scene scene;
    scene.balls_C = {{0.02, 0, 0}, {-0.02, 0.01, 0}, {0, -0.02, 0.01}};
    scene.walls = {{{0, 0, 1}, 0, 1e9, 0, 0.3}, {glm::normalize(glm::dvec3(1, 0.2, 0.1)), -0.05, 1e9, 0, 0.2}};
    core::Pose X_WD = At(0, 0, 0.03);
    scene.hand.Reset(X_WD);
    std::size_t at = 0;
    Move(scene, &X_WD, {-0.05, 0.02, 0.0}, 0.1, [&](const core::Wrench& F) {
      for (const double x : {F.force_N.x, F.force_N.y, F.force_N.z, F.torque_Nm.x, F.torque_Nm.y, F.torque_Nm.z}) {
        if (run == 0) first.push_back(x);
        if (run == 1) {
          EXPECT_EQ(x, first[at++]);
        }
      }
    });
  }
}

}  // namespace
}  // namespace vps
