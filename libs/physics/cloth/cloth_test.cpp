#include "physics/cloth/cloth.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "physics/testing/floor.hpp"
#include "physics/testing/trials/build.hpp"
#include "physics/testing/trials/drape.hpp"

namespace physics {
namespace {

using trials::kDt;

class Ball final : public ClothShape {
 public:
  explicit Ball(double radius_m) : ClothShape(glm::dvec3(0.0), radius_m) {}
  double Distance(const glm::dvec3& p_O, glm::dvec3* gradient_O) const override {
    const double length = glm::length(p_O);
    *gradient_O = length > 0.0 ? p_O / length : glm::dvec3(0, 0, 1);
    return length - radius_m();
  }
};

std::unique_ptr<Cloth> Make(const ClothParams& params) {
  auto cloth = Cloth::Create(params);
  EXPECT_TRUE(cloth.has_value()) << (cloth ? "" : cloth.error().detail);
  return std::move(*cloth);
}

ClothParams Square() {
  ClothParams params;
  params.size_x_m = params.size_y_m = 0.2;
  params.cells_x = params.cells_y = 12;
  return params;
}

int Add(Cloth* cloth, BodyKind kind, std::shared_ptr<const ClothShape> shape = nullptr, const core::Pose& X_WO = {}) {
  ClothBodyParams params;
  params.kind = kind;
  params.shape = std::move(shape);
  params.X_WO = X_WO;
  const auto body = cloth->AddBody(params);
  EXPECT_TRUE(body.has_value());
  return body.value_or(0);
}

int Bond(Cloth* cloth, int body, const std::vector<glm::dvec3>& points_W, double stiffness, double release = 1e30) {
  const auto bond = cloth->AddBond({body, stiffness, 1.0, release}, points_W);
  EXPECT_TRUE(bond.has_value()) << (bond ? "" : bond.error().detail);
  return bond.value_or(0);
}

// A sheet that was swung by a corner and released: folded, stretched and tumbling.
std::unique_ptr<Cloth> Thrown(double damping_per_s) {
  ClothParams params = Square();
  params.damping_per_s = damping_per_s;
  auto cloth = Make(params);
  const int hand = Add(cloth.get(), BodyKind::kKinematic);
  cloth->SetBody(hand, {});
  EXPECT_GT(cloth->Grip({hand, 500.0, 1.0}, {0.06, 0.06, -0.1}, {0.2, 0.2, 0.1}), 4);
  for (int i = 1; i <= 500; ++i) {
    const double t = i * kDt;
    cloth->SetBody(hand, {glm::angleAxis(6.0 * t, glm::normalize(glm::dvec3(1, 2, 0.5))),
                          glm::dvec3(0.2 * std::sin(9.0 * t), 0.3 * t, 0.2 * std::sin(14.0 * t))});
    cloth->Step(kDt);
  }
  cloth->Release(hand);
  return cloth;
}

TEST(Cloth, MomentumIsConservedInFreeFlight) {
  auto cloth = Thrown(4.0);
  const glm::dvec3 p = cloth->momentum_Ns();
  const glm::dvec3 L = cloth->angular_momentum_Nms();
  ASSERT_GT(glm::length(p), 1e-3);
  ASSERT_GT(glm::length(L), 1e-4);
  for (int i = 0; i < 5000; ++i) cloth->Step(kDt);
  EXPECT_LT(glm::length(cloth->momentum_Ns() - p), 1e-9 * glm::length(p));
  EXPECT_LT(glm::length(cloth->angular_momentum_Nms() - L), 1e-9 * glm::length(L));
}

TEST(Cloth, EnergyNeverGrowsInFreeFlight) {
  for (const double loss : {0.0, 4.0}) {
    auto cloth = Thrown(loss);
    double before_J = cloth->energy_J();  // then the most of the last fifth of a second
    for (int window = 0; window < 25; ++window) {
      double most_J = 0.0;
      for (int i = 0; i < 200; ++i) {
        cloth->Step(kDt);
        most_J = std::max(most_J, cloth->energy_J());
      }
      ASSERT_LE(most_J, before_J) << "after " << window * 0.2 << " s";
      before_J = most_J;
    }
    // Damping cannot take the motion of the sheet as a whole.
    const double whole_J = 0.5 * glm::dot(cloth->momentum_Ns(), cloth->momentum_Ns()) / cloth->mass_kg();
    EXPECT_GT(before_J, whole_J);
  }
}

// A free ball flies into the sheet: the sum of momenta and of angular momenta is conserved.
TEST(Cloth, ExchangesMomentumWithABall) {
  auto cloth = Make(Square());
  ClothBodyParams params;
  params.kind = BodyKind::kDynamic;
  params.mass.mass_kg = 0.02;
  params.mass.I_Cm_O_kg_m2 = glm::dmat3(0.4 * 0.02 * 0.03 * 0.03);
  params.shape = std::make_shared<Ball>(0.03);
  const int ball = *cloth->AddBody(params);
  core::Pose X_WO{{1, 0, 0, 0}, {0.031, 0.017, 0.06}};
  core::Twist V_WO{{3.0, 0.0, 0.0}, {0.1, 0.0, -0.8}};
  const glm::dvec3 start_p = params.mass.mass_kg * V_WO.linear_m_per_s;
  const glm::dvec3 start_L = glm::cross(X_WO.translation, start_p) + params.mass.I_Cm_O_kg_m2 * V_WO.angular_rad_per_s;
  bool has_touched = false;
  for (int i = 0; i < 400; ++i) {
    cloth->SetBody(ball, X_WO, V_WO);
    cloth->Step(kDt);
    // The ball's owner applies the impulse at the pose of the step's start, then moves the ball.
    const core::Wrench F = cloth->MeanWrenchOn(ball, X_WO.translation);
    has_touched = has_touched || glm::length(F.force_N) > 0.0;
    V_WO.linear_m_per_s += kDt / params.mass.mass_kg * F.force_N;
    V_WO.angular_rad_per_s += glm::inverse(params.mass.I_Cm_O_kg_m2) * (kDt * F.torque_Nm);
    X_WO.translation += kDt * V_WO.linear_m_per_s;
  }
  ASSERT_TRUE(has_touched);
  const glm::dvec3 p = params.mass.mass_kg * V_WO.linear_m_per_s;
  EXPECT_GT(glm::length(p - start_p), 1e-3);
  EXPECT_LT(glm::length(p + cloth->momentum_Ns() - start_p), 1e-12);
  // The contact point moves within a step, while the owner applies the impulse at the start of it: the error is the
  // distance of one step times the impulse.
  const glm::dvec3 L = glm::cross(X_WO.translation, p) + params.mass.I_Cm_O_kg_m2 * V_WO.angular_rad_per_s;
  EXPECT_LT(glm::length(L + cloth->angular_momentum_Nms() - start_L), 1e-3 * glm::length(p - start_p));
}

// The middle third of a strip that is pulled at both ends, where the ends' clamps no longer matter.
TEST(Cloth, AStretchedStripHasTheGivenStiffness) {
  for (const int cells : {4, 8}) {
    ClothParams params;
    params.size_x_m = 0.3;
    params.size_y_m = 0.06;
    params.cells_x = 5 * cells;
    params.cells_y = cells;
    params.stretch_stiffness_N_per_m = 3000.0;
    auto cloth = Make(params);
    const int fixed = Add(cloth.get(), BodyKind::kFixed);
    const int hand = Add(cloth.get(), BodyKind::kKinematic);
    cloth->SetBody(hand, {});
    const auto end = [&](double x) {
      std::vector<glm::dvec3> points;
      for (int j = 0; j <= cells; ++j) points.emplace_back(x, (static_cast<double>(j) / cells - 0.5) * 0.06, 0.0);
      return points;
    };
    Bond(cloth.get(), fixed, end(-0.15), 2e4);
    const int bond = Bond(cloth.get(), hand, end(0.15), 2e4);
    for (int i = 0; i < 3000; ++i) {
      cloth->SetBody(hand, {{1, 0, 0, 0}, {std::min(1.0, i / 500.0) * 0.003, 0, 0}});
      cloth->Step(kDt);
    }
    const auto at = [&](int i, int j) {
      return cloth->positions_W()[static_cast<std::size_t>(j * (5 * cells + 1) + i)];
    };
    const double strain = (at(3 * cells, cells / 2).x - at(2 * cells, cells / 2).x) / 0.06 - 1.0;
    const double narrowing = (at(5 * cells / 2, cells).y - at(5 * cells / 2, 0).y) / 0.06 - 1.0;
    const double tension_N = -cloth->BondForce_W(bond).x;
    EXPECT_NEAR(tension_N / (0.06 * strain), 3000.0, 30.0) << cells << " cells";
    EXPECT_NEAR(-narrowing / strain, 1.0 / 3.0, 0.01) << cells << " cells";
  }
}

// Clamped at its first two columns of nodes and bent by its own weight: q L^4 / (8 D) from the middle of the clamp.
double CantileverSag(int cells, double* expected_m) {
  ClothParams params;
  params.size_x_m = 0.2;
  params.size_y_m = 0.05;
  params.cells_x = cells;
  params.cells_y = cells / 4;
  params.bending_stiffness_Nm = 2e-3;
  params.damping_per_s = 8.0;
  params.acceleration_W = {0, 0, -0.05};
  auto cloth = Make(params);
  const int fixed = Add(cloth.get(), BodyKind::kFixed);
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j <= params.cells_y; ++j) {
      points.emplace_back(-0.1 + 0.2 * i / cells, -0.025 + 0.05 * j / params.cells_y, 0.0);
    }
  }
  Bond(cloth.get(), fixed, points, 2e4);
  for (int i = 0; i < 4000; ++i) cloth->Step(kDt);
  const double length_m = 0.2 * (1.0 - 0.5 / cells);
  *expected_m = params.density_kg_per_m2 * 0.05 * std::pow(length_m, 4) / (8.0 * params.bending_stiffness_Nm);
  return -cloth->positions_W()[static_cast<std::size_t>(cells)].z;
}

TEST(Cloth, ACantileverBendsLikeTheClosedForm) {
  double expected_m = 0.0;
  const double coarse_m = CantileverSag(8, &expected_m);
  const double coarse_error = std::abs(coarse_m / expected_m - 1.0);
  const double fine_m = CantileverSag(16, &expected_m);
  const double fine_error = std::abs(fine_m / expected_m - 1.0);
  EXPECT_LT(coarse_error, 0.06);
  EXPECT_LT(fine_error, 0.02);
  EXPECT_LT(fine_error, 0.5 * coarse_error);
}

TEST(Cloth, AHookBreaksAtItsBreakingForceOnly) {
  ClothParams params = Square();
  auto cloth = Make(params);
  const int post = Add(cloth.get(), BodyKind::kFixed);
  const int hand = Add(cloth.get(), BodyKind::kKinematic);
  cloth->SetBody(hand, {});
  const int hook = Bond(cloth.get(), post, {{-0.09, 0.0, 0.0}}, 2000.0, 3.5);
  ASSERT_GT(cloth->Grip({hand, 500.0, 1.0}, {0.09, -0.2, -0.1}, {0.2, 0.2, 0.1}), 4);
  double peak_N = 0.0;
  for (int i = 0; i < 4000 && cloth->held(hook) > 0; ++i) {
    cloth->SetBody(hand, {{1, 0, 0, 0}, {0.01 * i * kDt, 0, 0}});
    cloth->Step(kDt);
    peak_N = std::max(peak_N, glm::length(cloth->BondForce_W(hook)));
  }
  EXPECT_EQ(cloth->held(hook), 0);
  EXPECT_NEAR(peak_N, 3.5, 0.05);
  for (int i = 0; i < 3; ++i) cloth->Step(kDt);
  EXPECT_EQ(cloth->BondForce_W(hook), glm::dvec3(0.0));
}

// A ball presses the sheet on a floor until the gap equals the sheet's thickness, and wipes along it.
TEST(Cloth, NodesNeverEndAStepInsideAPart) {
  ClothParams params = Square();
  params.thickness_m = 0.002;
  params.X_WS.translation.z = 0.004;
  auto cloth = Make(params);
  Add(cloth.get(), BodyKind::kFixed, std::make_shared<Floor>());
  const int ball = Add(cloth.get(), BodyKind::kKinematic, std::make_shared<Ball>(0.03));
  const auto pose = [](double t) {
    const double z = std::max(0.0321, 0.05 - 0.1 * t);
    return core::Pose{{1, 0, 0, 0}, {t < 0.4 ? 0.0 : 0.15 * (t - 0.4), 0.01, z}};
  };
  cloth->SetBody(ball, pose(0.0));
  double deepest_m = 1.0;
  bool has_touched = false;
  for (int i = 1; i <= 800; ++i) {
    cloth->SetBody(ball, pose(i * kDt));
    cloth->Step(kDt);
    for (const glm::dvec3& x : cloth->positions_W()) {
      deepest_m = std::min({deepest_m, x.z, glm::length(x - pose(i * kDt).translation) - 0.03});
    }
    has_touched = has_touched || glm::length(cloth->MeanWrenchOn(ball, {}).force_N) > 0.0;
  }
  EXPECT_TRUE(has_touched);
  EXPECT_GT(deepest_m, 0.0005);  // half of the half thickness, the distance that nodes should keep
}

TEST(Cloth, ADrapeConvergesAsItsCellsShrink) {
  const DrapeResult finest = Drape(24);
  EXPECT_LT(finest.speed_m_per_s, 5e-4);
  const double coarse = std::abs(Drape(6).sag_m / finest.sag_m - 1.0);
  const double finer = std::abs(Drape(12).sag_m / finest.sag_m - 1.0);
  EXPECT_LT(coarse, 0.15);
  EXPECT_LT(finer, 0.4 * coarse);
}

TEST(Cloth, ARestoredRunContinuesBitForBit) {
  auto first = Thrown(4.0);
  Checkpoint checkpoint;
  checkpoint.BeginWriting();
  first->ExchangeState(&checkpoint);
  auto second = Thrown(0.0);
  for (int i = 0; i < 100; ++i) second->Step(kDt);
  auto third = Make(Square());
  Add(third.get(), BodyKind::kKinematic);
  checkpoint.BeginReading();
  third->ExchangeState(&checkpoint);
  for (int i = 0; i < 200; ++i) {
    first->Step(kDt);
    third->Step(kDt);
  }
  EXPECT_EQ(first->StateHash(), third->StateHash());
  EXPECT_NE(first->StateHash(), second->StateHash());
}

TEST(Cloth, RefusesInvalidParameters) {
  const auto is_refused = [](const std::function<void(ClothParams*)>& change) {
    ClothParams params;
    change(&params);
    return !Cloth::Create(params).has_value();
  };
  EXPECT_FALSE(is_refused([](ClothParams*) {}));
  EXPECT_TRUE(is_refused([](ClothParams* p) { p->cells_x = 1; }));
  EXPECT_TRUE(is_refused([](ClothParams* p) { p->size_y_m = 0.0; }));
  EXPECT_TRUE(is_refused([](ClothParams* p) { p->density_kg_per_m2 = -1.0; }));
  EXPECT_TRUE(is_refused([](ClothParams* p) { p->stretch_stiffness_N_per_m = std::nan(""); }));
  EXPECT_TRUE(is_refused([](ClothParams* p) { p->cells_x = 40; }));
  auto cloth = Make(ClothParams{});
  EXPECT_FALSE(cloth->AddBond({0, 100.0, 1.0}, {{0, 0, 0}}).has_value());  // no body
  const int body = Add(cloth.get(), BodyKind::kFixed);
  EXPECT_FALSE(cloth->AddBond({body, 100.0, 1.0}, {{1, 0, 0}}).has_value());  // not on the sheet
}

}  // namespace
}  // namespace physics
