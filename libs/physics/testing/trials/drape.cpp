#include "physics/testing/trials/drape.hpp"

#include <algorithm>

#include "physics/cloth/cloth.hpp"

namespace physics {
namespace {

constexpr double kGravity_m_per_s2 = 9.81;
constexpr double kStep_s = 1e-3;
constexpr std::uint64_t kSteps = 2000;

}  // namespace

DrapeResult Drape(int cells) {
  DrapeResult result;
  ClothParams params;
  params.size_x_m = params.size_y_m = kDrapeSide_m;
  params.cells_x = params.cells_y = cells;
  params.density_kg_per_m2 = kDrapeWeight_N_per_m2 / kGravity_m_per_s2;
  params.stretch_stiffness_N_per_m = 1000.0;
  params.bending_stiffness_Nm = kDrapeBendingStiffness_Nm;
  params.damping_per_s = 8.0;
  params.acceleration_W = {0.0, 0.0, -kGravity_m_per_s2};
  auto created = Cloth::Create(params);
  if (!created) return result;
  Cloth& cloth = **created;
  const auto frame = cloth.AddBody({});
  std::vector<glm::dvec3> points;
  for (int j = 0; j <= cells; ++j) points.emplace_back(0.0, (static_cast<double>(j) / cells - 0.5) * kDrapeSide_m, 0.0);
  if (!frame || !cloth.AddBond({*frame, 2e4, 1.0}, points)) return result;
  for (std::uint64_t i = 0; i < kSteps; ++i) cloth.Step(kStep_s);
  result.num_nodes = static_cast<int>(cloth.positions_W().size());
  result.num_steps = kSteps;
  const auto row = static_cast<std::size_t>(cells / 2 * (cells + 1));
  result.sag_m = -0.5 * (cloth.positions_W()[row].z + cloth.positions_W()[row + static_cast<std::size_t>(cells)].z);
  for (const glm::dvec3& v : cloth.velocities_W())
    result.speed_m_per_s = std::max(result.speed_m_per_s, glm::length(v));
  return result;
}

}  // namespace physics
