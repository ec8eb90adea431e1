#pragma once

#include <random>
#include <vector>

#include "physics/chain/chain.hpp"

namespace physics::test {

// Random numbers that are the same on every machine, unlike those of the distributions of <random>.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : engine_(seed) {}
  double In(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) / 9007199254740992.0);
  }
  glm::dvec3 Vector(double size) { return {In(-size, size), In(-size, size), In(-size, size)}; }
  glm::dquat Rotation() {
    return glm::normalize(glm::dquat(In(-1.0, 1.0), In(-1.0, 1.0), In(-1.0, 1.0), In(-1.0, 1.0)));
  }

 private:
  std::mt19937_64 engine_;
};

// An arm of seven joints with link masses of a light-weight robot (0.5 to 3 kg), no two axes parallel, centres of mass
// off the axes. `inertias`, when given, receives the principal inertias of the links.
inline std::vector<ChainLink> RandomArm(Draws* draws, std::vector<PrincipalInertia>* inertias = nullptr) {
  std::vector<ChainLink> links(7);
  for (std::size_t i = 0; i < links.size(); ++i) {
    ChainLink& link = links[i];
    link.parent = static_cast<int>(i) - 1;
    link.X_PJ = {draws->Rotation(), draws->Vector(0.2)};
    const double mass_kg = draws->In(0.5, 3.0);
    link.mass = BoxMass(mass_kg, {draws->In(0.05, 0.3), draws->In(0.05, 0.3), draws->In(0.05, 0.3)});
    const glm::dmat3 box = link.mass.I_Cm_O_kg_m2;
    const PrincipalInertia inertia{draws->Rotation(), {box[0][0], box[1][1], box[2][2]}};
    const glm::dmat3 R = glm::mat3_cast(inertia.R_OB);
    link.mass.I_Cm_O_kg_m2 = R * box * glm::transpose(R);
    if (inertias != nullptr) inertias->push_back(inertia);
    link.mass.p_OCm_m = draws->Vector(0.1);
  }
  return links;
}

inline ChainState RandomState(const Chain& chain, Draws* draws) {
  ChainState state = chain.MakeState();
  for (std::size_t i = 0; i < chain.num_joints(); ++i) {
    state.position[i] = draws->In(-3.0, 3.0);
    state.speed[i] = draws->In(-3.0, 3.0);
  }
  if (chain.is_free()) {
    state.X_WB = {draws->Rotation(), draws->Vector(5.0)};
    state.V_WB = {draws->Vector(1.0), draws->Vector(1.0)};
  }
  return state;
}

}  // namespace physics::test
