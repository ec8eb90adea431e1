#include "physics/testing/closed_form/impact.hpp"

#include <gtest/gtest.h>

namespace physics::closed_form {
namespace {

double Energy(const ImpactBody& body, const glm::dmat3& inertia) {
  return 0.5 * glm::dot(body.v_Cm_W, body.v_Cm_W) / body.inverse_mass_per_kg +
         0.5 * glm::dot(body.w_W, inertia * body.w_W);
}

TEST(Impact, CentralImpactEqualsThatOfTwoPointMassesOnALine) {
  // v1' = (m1 v1 + m2 v2 - m2 e (v1 - v2)) / (m1 + m2)
  for (const double e : {0.0, 0.5, 1.0}) {
    ImpactBody a{1.0 / 2.0, glm::dmat3(1.0), {0, 0, 0}, {-1.5, 0.2, 0}, {}};
    ImpactBody b{1.0 / 3.0, glm::dmat3(1.0), {0, 0, 0}, {0.5, 0, 0}, {}};
    Impact(&a, &b, {1, 0, 0}, e);
    EXPECT_NEAR(a.v_Cm_W.x, (2.0 * -1.5 + 3.0 * 0.5 - 3.0 * e * (-1.5 - 0.5)) / 5.0, 1e-15);
    EXPECT_NEAR(b.v_Cm_W.x, (2.0 * -1.5 + 3.0 * 0.5 + 2.0 * e * (-1.5 - 0.5)) / 5.0, 1e-15);
    EXPECT_EQ(a.v_Cm_W.y, 0.2);
  }
}

TEST(Impact, EccentricElasticImpactConservesEnergyMomentumAndAngularMomentum) {
  const glm::dmat3 I_a(glm::dvec3(0.02, 0.001, 0), glm::dvec3(0.001, 0.03, 0.002), glm::dvec3(0, 0.002, 0.04));
  const glm::dmat3 I_b(glm::dvec3(0.5, 0, 0.01), glm::dvec3(0, 0.4, 0), glm::dvec3(0.01, 0, 0.3));
  ImpactBody a{1.0 / 2.0, glm::inverse(I_a), {0.05, 0.02, -0.1}, {-0.7, 0.3, 0.1}, {0.4, -1.0, 2.0}};
  ImpactBody b{1.0 / 7.0, glm::inverse(I_b), {-0.2, 0.1, 0.04}, {0.2, 0.0, -0.3}, {0.1, 0.3, -0.5}};
  const double before = Energy(a, I_a) + Energy(b, I_b);
  const auto angular = [&] {  // about the contact point
    return I_a * a.w_W - glm::cross(a.p_CmC_W, 2.0 * a.v_Cm_W) + I_b * b.w_W - glm::cross(b.p_CmC_W, 7.0 * b.v_Cm_W);
  };
  const glm::dvec3 L = angular();
  const glm::dvec3 p = 2.0 * a.v_Cm_W + 7.0 * b.v_Cm_W;
  EXPECT_GT(Impact(&a, &b, glm::normalize(glm::dvec3(1, 0.2, -0.1)), 1.0), 0.1);
  EXPECT_NEAR(Energy(a, I_a) + Energy(b, I_b), before, 1e-14);
  EXPECT_LT(glm::length(angular() - L), 1e-14);
  EXPECT_LT(glm::length(2.0 * a.v_Cm_W + 7.0 * b.v_Cm_W - p), 1e-14);
  EXPECT_EQ(Impact(&a, &b, glm::normalize(glm::dvec3(1, 0.2, -0.1)), 1.0), 0.0) << "they part now";
}

}  // namespace
}  // namespace physics::closed_form
